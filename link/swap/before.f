C     ATTITUDE OF A SPACECRAFT THAT TUMBLES, WITH A DAMPER THAT IS OFF:
C     EULER'S EQUATIONS AND THE QUATERNION BY THE RUNGE-KUTTA METHOD.
C     THE PROGRAM AS IT WAS. SEE AFTER.F FOR WHAT CHANGED.
C
      PROGRAM TUMBLE
      DOUBLE PRECISION AJ(3)
      COMMON /INERT/ AJ
      DOUBLE PRECISION Y(7), T, DT, E, E0, AL, AL0
      INTEGER I, K
      DATA AJ /40.0D0, 52.0D0, 65.0D0/
      DATA Y /1.0D0, 3*0.0D0, 0.02D0, 1.5D0, 0.02D0/
      T = 0.0D0
      DT = 0.2D0
      CALL CHECK(Y, E0, AL0)
      WRITE (*, 10)
   10 FORMAT ('    TIME, S    ENERGY DRIFT  MOMENTUM DRIFT  |Q| - 1')
      DO 30 K = 1, 10
         DO 20 I = 1, 500
            CALL RK4(Y, T, DT)
   20    CONTINUE
         CALL CHECK(Y, E, AL)
         WRITE (*, 40) T, (E - E0)/E0, (AL - AL0)/AL0,
     1      SQRT(Y(1)**2 + Y(2)**2 + Y(3)**2 + Y(4)**2) - 1.0D0
   30 CONTINUE
   40 FORMAT (F11.1, 1P, E16.2, E14.2, E13.2)
      IF (ABS(E - E0) .LT. 1.0D-6*E0) STOP 2
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
C
C     RATES OF Q(4) AND OMEGA(3).
      SUBROUTINE RATES(Y, F)
      DOUBLE PRECISION AJ(3)
      COMMON /INERT/ AJ
      DOUBLE PRECISION Y(7), F(7)
      F(1) = 0.5D0*(-Y(2)*Y(5) - Y(3)*Y(6) - Y(4)*Y(7))
      F(2) = 0.5D0*( Y(1)*Y(5) + Y(3)*Y(7) - Y(4)*Y(6))
      F(3) = 0.5D0*( Y(1)*Y(6) + Y(4)*Y(5) - Y(2)*Y(7))
      F(4) = 0.5D0*( Y(1)*Y(7) + Y(2)*Y(6) - Y(3)*Y(5))
      F(5) = (AJ(2) - AJ(3))*Y(6)*Y(7)/AJ(1)
      F(6) = (AJ(3) - AJ(1))*Y(7)*Y(5)/AJ(2)
      F(7) = (AJ(1) - AJ(2))*Y(5)*Y(6)/AJ(3)
      END
C
C     ONE STEP OF THE CLASSICAL METHOD OF RUNGE AND KUTTA.
      SUBROUTINE RK4(Y, T, DT)
      DOUBLE PRECISION Y(7), T, DT, Z(7), F1(7), F2(7), F3(7), F4(7)
      INTEGER I
      CALL RATES(Y, F1)
      DO 10 I = 1, 7
         Z(I) = Y(I) + 0.5D0*DT*F1(I)
   10 CONTINUE
      CALL RATES(Z, F2)
      DO 20 I = 1, 7
         Z(I) = Y(I) + 0.5D0*DT*F2(I)
   20 CONTINUE
      CALL RATES(Z, F3)
      DO 30 I = 1, 7
         Z(I) = Y(I) + DT*F3(I)
   30 CONTINUE
      CALL RATES(Z, F4)
      DO 40 I = 1, 7
         Y(I) = Y(I) + DT*(F1(I) + 2.0D0*(F2(I) + F3(I)) + F4(I))/6.0D0
   40 CONTINUE
      T = T + DT
      END
