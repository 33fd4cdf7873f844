!> Tops for the tests, and 40-digit solutions that were made without elliptic functions.
module test_exact_top_reference
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_exact_top, only: lagrange_top_t
   use nutate_kinds, only: wp
   use nutate_status, only: status_t
   use test_support, only: random_unit, random_unit_quaternion, random_vector
   implicit none
   private

   public :: sample_t, prepared, random_sample, moments, fastest, rows

   !> A top in its own axes.
   type :: sample_t
      real(wp) :: j1, j3, mgl, q0(4), momentum(3)
   end type sample_t

   !> Taylor series of Euler's equations with gravity along space axis -3 and of the kinematics, order 50, 60 digits
   !> (gmpy2). J1, J3, m g l, q(0), L(0), t, amplification of round-off, q(t), L(t).
   real(wp), parameter :: rows(19, 10) = reshape([ &
      ! A general motion, and the same hanging.
      2.0_wp, 0.5_wp, 1.5_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp, 2.0_wp, 3.0_wp, 10.0_wp, 1.0_wp, &
      -6.46485731778988392534e-01_wp, -4.22860035715015672457e-01_wp, -2.88238343010771983005e-01_wp, &
      5.65830581021992926253e-01_wp, &
      -2.28788055756516594010e+00_wp, -1.70537561274732163699e+00_wp, 3.00000000000000000000e+00_wp, &
      2.0_wp, 0.5_wp, -1.5_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp, 2.0_wp, 3.0_wp, 10.0_wp, 1.0_wp, &
      8.66195150023137025199e-01_wp, 2.78882302869930240156e-01_wp, 1.90097351570087172484e-01_wp, &
      -3.68501859084046300998e-01_wp, &
      -1.75491958795266969503e+00_wp, -7.43847522469538187555e-01_wp, 3.00000000000000000000e+00_wp, &
      ! Motions again and again through the upper vertical, with spin and as a pendulum.
      2.0_wp, 1.0_wp, 1.5_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      3.0_wp, 1.0_wp, 2.0_wp, 10.0_wp, 1.0_wp, &
      -7.78552880250626058575e-01_wp, 1.85107409090831486616e-02_wp, -5.41997686774877807567e-01_wp, &
      -3.15834248705127864608e-01_wp, &
      -2.70933439874863512179e-02_wp, 3.67811305300577144139e+00_wp, 2.00000000000000000000e+00_wp, &
      2.0_wp, 1.0_wp, 3.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      10.0_wp, 0.0_wp, 0.0_wp, 3.0_wp, 1.0_wp, &
      -6.96522196063749238809e-02_wp, 9.97571334944977917615e-01_wp, 0.00000000000000000000e+00_wp, &
      0.00000000000000000000e+00_wp, &
      1.11302994406841421553e+01_wp, 0.00000000000000000000e+00_wp, 0.00000000000000000000e+00_wp, &
      ! Next to the unstable upright top, next to its separatrix.
      2.0_wp, 1.0_wp, 3.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0e-6_wp, 0.0_wp, 3.0_wp, 30.0_wp, 1.0_wp, &
      -9.55214292128637872492e-01_wp, -4.09957269260844890186e-06_wp, 2.28695375717238085945e-06_wp, &
      2.95914947393923671057e-01_wp, &
      -1.49001731105844123920e-05_wp, 1.75460688264019813982e-05_wp, 3.00000000000000000000e+00_wp, &
      ! Through the lower vertical, with spin and as a pendulum.
      2.0_wp, 1.0_wp, 3.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp, -2.0_wp, 3.0_wp, 10.0_wp, 1.0_wp, &
      2.56719714009975740558e-01_wp, -9.23791417704666081390e-01_wp, -7.56564409686007981458e-02_wp, &
      -2.73825688995397294561e-01_wp, &
      -1.18627333475681263629e+00_wp, 4.59894669333016387469e-01_wp, 3.00000000000000000000e+00_wp, &
      2.0_wp, 1.0_wp, -3.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      0.5_wp, 0.25_wp, 0.0_wp, 10.0_wp, 1.0_wp, &
      9.99191613360726670018e-01_wp, -3.59568607037722839583e-02_wp, -1.79784303518861419791e-02_wp, &
      0.00000000000000000000e+00_wp, &
      4.67942838432119181820e-01_wp, 2.33971419216059590910e-01_wp, 0.00000000000000000000e+00_wp, &
      ! Next to no gravity, and none.
      2.0_wp, 1.0_wp, 2.0_wp**(-40), 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp, 2.0_wp, 3.0_wp, 10.0_wp, 1.0_wp, &
      -3.98849096992389011661e-01_wp, 4.19237216432588312046e-02_wp, -4.61612613931929842662e-03_wp, &
      -9.16046118255735149975e-01_wp, &
      5.40887767451152839140e-01_wp, -2.16966366587582430082e+00_wp, 3.00000000000000000000e+00_wp, &
      2.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp, 2.0_wp, 3.0_wp, 10.0_wp, 1.0_wp, &
      -3.98849096993362578409e-01_wp, 4.19237216425850480775e-02_wp, -4.61612613924510969090e-03_wp, &
      -9.16046118255342466408e-01_wp, &
      5.40887767455412457811e-01_wp, -2.16966366587475941353e+00_wp, 3.00000000000000000000e+00_wp, &
      ! A flat body.
      1.0_wp, 2.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp, 0.25_wp, 4.0_wp, 5.0_wp, 1.0_wp, &
      6.57140762532609852258e-01_wp, 3.19103629298143972525e-02_wp, -5.41403248537592233929e-02_wp, &
      -7.51143509710679065677e-01_wp, &
      -9.43377141052058318446e-01_wp, 4.33978517775681000336e-01_wp, 4.00000000000000000000e+00_wp &
      ], [19, 10])

contains

   !> A top that must be accepted; a refused one stays at rest, which fails the checks of its motion.
   type(lagrange_top_t) function prepared(sample) result(top)
      type(sample_t), intent(in) :: sample
      type(status_t) :: status
      call top%prepare(sample%j1, sample%j3, sample%mgl, sample%q0, sample%momentum, status)
   end function prepared

   type(sample_t) function random_sample(seed) result(sample)
      integer(int64), intent(inout) :: seed
      sample%j1 = 0.5_wp + random_unit(seed)
      sample%j3 = 0.2_wp + random_unit(seed)
      sample%mgl = 3*(random_unit(seed) - 0.5_wp)
      sample%q0 = random_unit_quaternion(seed)
      sample%momentum = 2*random_vector(seed)
   end function random_sample

   pure function moments(sample)
      type(sample_t), intent(in) :: sample
      real(wp) :: moments(3)
      moments = [sample%j1, sample%j1, sample%j3]
   end function moments

   !> The fastest rate of a top (rad/s): the unit of turns.
   pure real(wp) function fastest(sample)
      type(sample_t), intent(in) :: sample
      fastest = norm2(sample%momentum)/min(sample%j1, sample%j3) + sqrt(2*abs(sample%mgl)/sample%j1)
   end function fastest

end module test_exact_top_reference
