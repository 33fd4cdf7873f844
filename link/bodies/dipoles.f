C     DIPOLES IN A BOX: 10000 MAGNETIC RODS ON A LATTICE OF 25 BY 20 BY
C     20 PLACES, PERIODIC, EACH IN THE FIELD OF ITS SIX NEIGHBOURS. THE
C     TORQUES ARE COMPUTED HERE; NUTATE MOVES THE RODS. LENGTHS IN UNITS
C     OF THE LATTICE, MU0/4PI AND THE MOMENT OF A ROD ARE 1.
C
      PROGRAM DIPOLE
      INTEGER N, NX, NY, NZ, LWORK, MBAD
      PARAMETER (NX = 25, NY = 20, NZ = 20, N = NX*NY*NZ)
      PARAMETER (LWORK = 27, MBAD = 10)
      DOUBLE PRECISION Q(4,N), AL(3,N), TOR(3,N), D(3,N), WORK(LWORK)
      DOUBLE PRECISION AJ(3,3), DT, U, T, E, E0, WORST, A, ENERGY
      INTEGER IC(1), IBAD(MBAD), NBAD, INFO, I, K, L
      DATA AJ /1.0D0, 3*0.0D0, 1.0D0, 3*0.0D0, 0.1D0/, IC /0/
      DT = 0.01D0
      DO 10 I = 1, N
C        SOME ATTITUDES THAT FOLLOW NO PATTERN; AT REST
         A = MOD(I*0.6180339887D0, 1.0D0)
         U = MOD(I*0.7548776662D0, 1.0D0)
         Q(1,I) = SQRT(1.0D0 - U)*COS(6.283185307179586D0*A)
         Q(2,I) = SQRT(1.0D0 - U)*SIN(6.283185307179586D0*A)
         Q(3,I) = SQRT(U)
         Q(4,I) = 0.0D0
         DO 10 K = 1, 3
   10 AL(K,I) = 0.0D0
      CALL NUBSET(1, AJ, 0, WORK, LWORK, INFO)
      IF (INFO .NE. 0) STOP 1
      CALL FIELD(NX, NY, NZ, Q, D, TOR, U)
C     THE MOMENTA GO HALF A STEP BEHIND THE ATTITUDES, ONCE
      CALL NUBKIK(N, -0.5D0*DT, IC, Q, AL, TOR, MBAD, IBAD, NBAD, WORK,
     1            LWORK, INFO)
      IF (INFO .NE. 0) STOP 1
      WORST = 0.0D0
      WRITE (*, 20)
   20 FORMAT ('   TIME      POTENTIAL        KINETIC          ENERGY')
      DO 60 L = 1, 200
         CALL NUBODY(N, DT, IC, Q, AL, TOR, MBAD, IBAD, NBAD, WORK,
     1               LWORK, INFO)
         IF (INFO .GT. 0) WRITE (*, *) NBAD, ' FAILED, FIRST', IBAD(1)
         IF (INFO .NE. 0) STOP 1
         CALL FIELD(NX, NY, NZ, Q, D, TOR, U)
         T = 0.0D0
         DO 40 I = 1, N
   40    T = T + ENERGY(DT, AJ, D(1,I), AL(1,I), TOR(1,I))
         E = T + U
         IF (L .EQ. 1) E0 = E
         WORST = MAX(WORST, ABS(E - E0))
         IF (MOD(L, 50) .EQ. 0) WRITE (*, 50) L*DT, U, T, E
   50    FORMAT (F7.2, 3F16.6)
   60 CONTINUE
      WRITE (*, 70) WORST/ABS(E0)
   70 FORMAT ('LARGEST CHANGE OF THE ENERGY', 1PE9.1)
      IF (.NOT. WORST .LT. 1.0D-3*ABS(E0)) STOP 3
      END
C
C     KINETIC ENERGY OF A ROD WITH ITS MOMENTUM AT THE TIME OF D: HALF A
C     STEP ON. THE COMPONENT ALONG D HAS AJ(3,3), THE REST AJ(1,1).
      DOUBLE PRECISION FUNCTION ENERGY(DT, AJ, D, AL, TOR)
      DOUBLE PRECISION DT, AJ(3,3), D(3), AL(3), TOR(3), X, S, P
      INTEGER K
      S = 0.0D0
      P = 0.0D0
      DO 10 K = 1, 3
         X = AL(K) + 0.5D0*DT*TOR(K)
         S = S + X*X
   10 P = P + X*D(K)
      ENERGY = 0.5D0*((S - P*P)/AJ(1,1) + P*P/AJ(3,3))
      END
C
C     DIRECTIONS D OF THE DIPOLES, TORQUES AND POTENTIAL ENERGY.
      SUBROUTINE FIELD(NX, NY, NZ, Q, D, TOR, U)
      INTEGER NX, NY, NZ, IX, IY, IZ, I, K
      DOUBLE PRECISION Q(4,*), D(3,NX,NY,NZ), TOR(3,NX,NY,NZ), U, B(3)
      I = 0
      DO 10 IZ = 1, NZ
      DO 10 IY = 1, NY
      DO 10 IX = 1, NX
         I = I + 1
         D(1,IX,IY,IZ) = 2.0D0*(Q(2,I)*Q(4,I) + Q(1,I)*Q(3,I))
         D(2,IX,IY,IZ) = 2.0D0*(Q(3,I)*Q(4,I) - Q(1,I)*Q(2,I))
   10 D(3,IX,IY,IZ) = 1.0D0 - 2.0D0*(Q(2,I)**2 + Q(3,I)**2)
      U = 0.0D0
      DO 30 IZ = 1, NZ
      DO 30 IY = 1, NY
      DO 30 IX = 1, NX
C        A NEIGHBOUR IN DIRECTION E ADDS 3 (M.E) E - M
         DO 20 K = 1, 3
         B(K) = -D(K,1+MOD(IX,NX),IY,IZ) - D(K,1+MOD(IX+NX-2,NX),IY,IZ)
     1        - D(K,IX,1+MOD(IY,NY),IZ) - D(K,IX,1+MOD(IY+NY-2,NY),IZ)
     2        - D(K,IX,IY,1+MOD(IZ,NZ)) - D(K,IX,IY,1+MOD(IZ+NZ-2,NZ))
   20    CONTINUE
         B(1) = B(1) + 3.0D0*(D(1,1+MOD(IX,NX),IY,IZ)
     1        + D(1,1+MOD(IX+NX-2,NX),IY,IZ))
         B(2) = B(2) + 3.0D0*(D(2,IX,1+MOD(IY,NY),IZ)
     1        + D(2,IX,1+MOD(IY+NY-2,NY),IZ))
         B(3) = B(3) + 3.0D0*(D(3,IX,IY,1+MOD(IZ,NZ))
     1        + D(3,IX,IY,1+MOD(IZ+NZ-2,NZ)))
         U = U - 0.5D0*(D(1,IX,IY,IZ)*B(1) + D(2,IX,IY,IZ)*B(2)
     1         + D(3,IX,IY,IZ)*B(3))
         TOR(1,IX,IY,IZ) = D(2,IX,IY,IZ)*B(3) - D(3,IX,IY,IZ)*B(2)
         TOR(2,IX,IY,IZ) = D(3,IX,IY,IZ)*B(1) - D(1,IX,IY,IZ)*B(3)
   30 TOR(3,IX,IY,IZ) = D(1,IX,IY,IZ)*B(2) - D(2,IX,IY,IZ)*B(1)
      END
