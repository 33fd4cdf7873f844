C     ATTITUDE OF A SPACECRAFT THAT TUMBLES, WITH A DAMPER THAT IS OFF:
C     THE PROGRAM BEFORE.F WITH NUTATE IN THE PLACE OF RUNGE-KUTTA.
C     CHANGED LINES END IN THE COLUMNS FROM 73 ON WITH  NUTATE. GONE
C     ARE THE SUBROUTINES RATES AND RK4.
C
      PROGRAM TUMBLE
      DOUBLE PRECISION AJ(3)
      COMMON /INERT/ AJ
      DOUBLE PRECISION Y(7), T, DT, E, E0, AL, AL0
      INTEGER I, K
      DOUBLE PRECISION TENSOR(3,3), ZERO(3), P(4), RUSER(1), WORK(300)  NUTATE
      INTEGER IUSER(1), INFO                                            NUTATE
      EXTERNAL NUNONE                                                   NUTATE
      DATA AJ /40.0D0, 52.0D0, 65.0D0/
      DATA Y /1.0D0, 3*0.0D0, 0.02D0, 1.5D0, 0.02D0/
      DATA TENSOR /9*0.0D0/, ZERO /3*0.0D0/                             NUTATE
      T = 0.0D0
      DT = 0.2D0
      DO 5 I = 1, 3                                                     NUTATE
         TENSOR(I,I) = AJ(I)                                            NUTATE
    5 CONTINUE                                                          NUTATE
      CALL NUINIT(TENSOR, 0.0D0, ZERO, ZERO, ZERO, ZERO, ZERO, 1, 4, 0, NUTATE
     1            WORK, 300, INFO)                                      NUTATE
      IF (INFO .NE. 0) STOP 1                                           NUTATE
      CALL NUSETP(Y(1), Y(5), P, WORK, 300, INFO)                       NUTATE
      CALL CHECK(Y, E0, AL0)
      WRITE (*, 10)
   10 FORMAT ('    TIME, S    ENERGY DRIFT  MOMENTUM DRIFT  |Q| - 1')
      DO 30 K = 1, 10
         CALL NUSTEP(500, DT, T, Y(1), P, NUNONE, NUNONE, IUSER, RUSER, NUTATE
     1               WORK, 300, INFO)                                   NUTATE
         IF (INFO .NE. 0) STOP 1                                        NUTATE
         CALL NUOMEG(Y(1), P, Y(5), WORK, 300, INFO)                    NUTATE
         CALL CHECK(Y, E, AL)
         WRITE (*, 40) T, (E - E0)/E0, (AL - AL0)/AL0,
     1      SQRT(Y(1)**2 + Y(2)**2 + Y(3)**2 + Y(4)**2) - 1.0D0
   30 CONTINUE
   40 FORMAT (F11.1, 1P, E16.2, E14.2, E13.2)
      IF (ABS(E - E0) .GT. 1.0D-13*E0) STOP 3                           NUTATE
      END
C
C     ENERGY AND LENGTH OF THE ANGULAR MOMENTUM.
      SUBROUTINE CHECK(Y, E, AL)
      DOUBLE PRECISION AJ(3)
      COMMON /INERT/ AJ
      DOUBLE PRECISION Y(7), E, AL
      INTEGER I
      E = 0.0D0
      AL = 0.0D0
      DO 10 I = 1, 3
         E = E + 0.5D0*AJ(I)*Y(4+I)**2
         AL = AL + (AJ(I)*Y(4+I))**2
   10 CONTINUE
      AL = SQRT(AL)
      END
