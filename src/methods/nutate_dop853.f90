!> The explicit Runge-Kutta method of order 8 of Dormand and Prince with estimates of orders 5 and 3, and the attitude
!> normalised after every step: a baseline.
!>
!> Coefficients: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), code
!> DOP853. A step takes 12 evaluations; the first of a step is not taken over from the one before, since neither the
!> result nor the estimate asks for an evaluation at the end.
module nutate_dop853
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   use nutate_rigid_rates, only: begin_step, end_step, end_wheels, get_error, get_rates, n_rates, prepare_rates, &
      rigid_rates_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: dop853_t, estimate_of_fifth, get_stages
   ! The coefficients under the names of the literature; to be renamed where they are used.
   public :: a, b, c, b3, e5

   !> Number of stages.
   integer, parameter :: n_stages = 12

   !> cᵢ; shape (12).
   real(wp), parameter :: c(n_stages) = [ &
      0.0_wp, 0.526001519587677318785587544488e-1_wp, 0.789002279381515978178381316732e-1_wp, &
      0.118350341907227396726757197510_wp, 0.281649658092772603273242802490_wp, 1.0_wp/3, 0.25_wp, &
      0.307692307692307692307692307692_wp, 0.651282051282051282051282051282_wp, 0.6_wp, &
      0.857142857142857142857142857142_wp, 1.0_wp]

   !> aᵢⱼ as a(j, i): the weights of a stage i stand in a column; shape (11, 2:12).
   real(wp), parameter :: a(n_stages - 1, 2:n_stages) = reshape([ &
      5.26001519587677318785587544488e-2_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      0.0_wp, &
      1.97250569845378994544595329183e-2_wp, 5.91751709536136983633785987549e-2_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      2.95875854768068491816892993775e-2_wp, 0.0_wp, 8.87627564304205475450678981324e-2_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      2.41365134159266685502369798665e-1_wp, 0.0_wp, -8.84549479328286085344864962717e-1_wp, &
      9.24834003261792003115737966543e-1_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      3.7037037037037037037037037037e-2_wp, 0.0_wp, 0.0_wp, 1.70828608729473871279604482173e-1_wp, &
      1.25467687566822425016691814123e-1_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      3.7109375e-2_wp, 0.0_wp, 0.0_wp, 1.70252211019544039314978060272e-1_wp, 6.02165389804559606850219397283e-2_wp, &
      -1.7578125e-2_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      3.70920001185047927108779319836e-2_wp, 0.0_wp, 0.0_wp, 1.70383925712239993810214054705e-1_wp, &
      1.07262030446373284651809199168e-1_wp, -1.53194377486244017527936158236e-2_wp, &
      8.27378916381402288758473766002e-3_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      6.24110958716075717114429577812e-1_wp, 0.0_wp, 0.0_wp, -3.36089262944694129406857109825_wp, &
      -8.68219346841726006818189891453e-1_wp, 2.75920996994467083049415600797e1_wp, &
      2.01540675504778934086186788979e1_wp, -4.34898841810699588477366255144e1_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      4.77662536438264365890433908527e-1_wp, 0.0_wp, 0.0_wp, -2.48811461997166764192642586468_wp, &
      -5.90290826836842996371446475743e-1_wp, 2.12300514481811942347288949897e1_wp, &
      1.52792336328824235832596922938e1_wp, -3.32882109689848629194453265587e1_wp, &
      -2.03312017085086261358222928593e-2_wp, 0.0_wp, 0.0_wp, &
      -9.3714243008598732571704021658e-1_wp, 0.0_wp, 0.0_wp, 5.18637242884406370830023853209_wp, &
      1.09143734899672957818500254654_wp, -8.14978701074692612513997267357_wp, &
      -1.85200656599969598641566180701e1_wp, 2.27394870993505042818970056734e1_wp, &
      2.49360555267965238987089396762_wp, -3.0467644718982195003823669022_wp, 0.0_wp, &
      2.27331014751653820792359768449_wp, 0.0_wp, 0.0_wp, -1.05344954667372501984066689879e1_wp, &
      -2.00087205822486249909675718444_wp, -1.79589318631187989172765950534e1_wp, &
      2.79488845294199600508499808837e1_wp, -2.85899827713502369474065508674_wp, &
      -8.87285693353062954433549289258_wp, 1.23605671757943030647266201528e1_wp, &
      6.43392746015763530355970484046e-1_wp], &
      [n_stages - 1, n_stages - 1])

   !> bᵢ, order 8; shape (12).
   real(wp), parameter :: b(n_stages) = [ &
      5.42937341165687622380535766363e-2_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 4.45031289275240888144113950566_wp, &
      1.89151789931450038304281599044_wp, -5.8012039600105847814672114227_wp, 3.1116436695781989440891606237e-1_wp, &
      -1.52160949662516078556178806805e-1_wp, 2.01365400804030348374776537501e-1_wp, &
      4.47106157277725905176885569043e-2_wp]

   !> b - b̂ of the method of order 5; shape (12).
   real(wp), parameter :: e5(n_stages) = [ &
      0.1312004499419488073250102996e-1_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -0.1225156446376204440720569753e1_wp, &
      -0.4957589496572501915214079952_wp, 0.1664377182454986536961530415e1_wp, -0.3503288487499736816886487290_wp, &
      0.3341791187130174790297318841_wp, 0.8192320648511571246570742613e-1_wp, -0.2235530786388629525884427845e-1_wp]

   !> Weights of the method of order 3: stages 1, 9 and 12.
   real(wp), parameter :: b3(3) = [ &
      0.244094488188976377952755905512_wp, 0.733846688281611857341361741547_wp, &
      0.220588235294117647058823529412e-1_wp]

   !> One step of the method. `step` allocates nothing.
   type, extends(stepper_t) :: dop853_t
      type(rigid_rates_t), private :: rates
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: transfer
   end type dop853_t

contains

   !> Of the settings `attitude` and `conserve` count. No errors of its own.
   subroutine set_up(self, system, settings, status)
      class(dop853_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      call prepare_rates(self%rates, system, settings%attitude, settings%conserve, a)
   end subroutine set_up

   !> One step. Errors, with the state as it was: `NUTATE_OFF_BRANCH` for a step so long that its stages run away,
   !> `NUTATE_NOT_FINITE`, `NUTATE_BAD_ARGUMENT` for a state off the constraint manifold.
   subroutine advance(self, system, state, dt, window_time, status)
      class(dop853_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: y(n_rates), change(n_rates), last(n_rates), fifth(n_rates), k(n_rates, n_stages)
      call begin_step(self%rates, system, state, dt, window_time, y)
      call get_stages(self%rates, system, y, k)
      change = b(1)*k(:, 1) + b(6)*k(:, 6) + b(7)*k(:, 7) + b(8)*k(:, 8) + b(9)*k(:, 9) + b(10)*k(:, 10) &
               + b(11)*k(:, 11) + b(12)*k(:, 12)
      last = y + change
      call end_step(self%rates, last, state, status)
      if (status%code /= 0) return
      if (self%rates%n_wheels > 0) call end_wheels(self%rates, state)
      self%work(:) = self%rates%work
      fifth = estimate_of_fifth(k)
      self%error_estimate = estimate(k, change, fifth, y)
      if (self%rates%estimates) call get_error(self%rates, last, fifth, e5, self%step_error)
   end subroutine advance

   !> k = Δt ẏ of all stages; shape (n_rates, 12). Terms with vanishing coefficients are left out.
   pure subroutine get_stages(rates, system, y, k)
      type(rigid_rates_t), intent(inout) :: rates
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: y(n_rates)
      real(wp), intent(out) :: k(n_rates, n_stages)
      real(wp) :: stage(n_rates)
      call get_rates(rates, system, c(1), y, b(1), k(:, 1))
      stage = y + a(1, 2)*k(:, 1)
      call get_rates(rates, system, c(2), stage, b(2), k(:, 2))
      stage = y + a(1, 3)*k(:, 1) + a(2, 3)*k(:, 2)
      call get_rates(rates, system, c(3), stage, b(3), k(:, 3))
      stage = y + a(1, 4)*k(:, 1) + a(3, 4)*k(:, 3)
      call get_rates(rates, system, c(4), stage, b(4), k(:, 4))
      stage = y + a(1, 5)*k(:, 1) + a(3, 5)*k(:, 3) + a(4, 5)*k(:, 4)
      call get_rates(rates, system, c(5), stage, b(5), k(:, 5))
      stage = y + a(1, 6)*k(:, 1) + a(4, 6)*k(:, 4) + a(5, 6)*k(:, 5)
      call get_rates(rates, system, c(6), stage, b(6), k(:, 6))
      stage = y + a(1, 7)*k(:, 1) + a(4, 7)*k(:, 4) + a(5, 7)*k(:, 5) + a(6, 7)*k(:, 6)
      call get_rates(rates, system, c(7), stage, b(7), k(:, 7))
      stage = y + a(1, 8)*k(:, 1) + a(4, 8)*k(:, 4) + a(5, 8)*k(:, 5) + a(6, 8)*k(:, 6) + a(7, 8)*k(:, 7)
      call get_rates(rates, system, c(8), stage, b(8), k(:, 8))
      stage = y + a(1, 9)*k(:, 1) + a(4, 9)*k(:, 4) + a(5, 9)*k(:, 5) + a(6, 9)*k(:, 6) + a(7, 9)*k(:, 7) &
               + a(8, 9)*k(:, 8)
      call get_rates(rates, system, c(9), stage, b(9), k(:, 9))
      stage = y + a(1, 10)*k(:, 1) + a(4, 10)*k(:, 4) + a(5, 10)*k(:, 5) + a(6, 10)*k(:, 6) + a(7, 10)*k(:, 7) &
               + a(8, 10)*k(:, 8) + a(9, 10)*k(:, 9)
      call get_rates(rates, system, c(10), stage, b(10), k(:, 10))
      stage = y + a(1, 11)*k(:, 1) + a(4, 11)*k(:, 4) + a(5, 11)*k(:, 5) + a(6, 11)*k(:, 6) + a(7, 11)*k(:, 7) &
               + a(8, 11)*k(:, 8) + a(9, 11)*k(:, 9) + a(10, 11)*k(:, 10)
      call get_rates(rates, system, c(11), stage, b(11), k(:, 11))
      stage = y + a(1, 12)*k(:, 1) + a(4, 12)*k(:, 4) + a(5, 12)*k(:, 5) + a(6, 12)*k(:, 6) + a(7, 12)*k(:, 7) &
               + a(8, 12)*k(:, 8) + a(9, 12)*k(:, 9) + a(10, 12)*k(:, 10) + a(11, 12)*k(:, 11)
      call get_rates(rates, system, c(12), stage, b(12), k(:, 12))
   end subroutine get_stages

   !> The difference to the method of order 5; shape (n_rates).
   pure function estimate_of_fifth(k) result(fifth)
      !> Shape (n_rates, 12).
      real(wp), intent(in) :: k(n_rates, n_stages)
      real(wp) :: fifth(n_rates)
      fifth = e5(1)*k(:, 1) + e5(6)*k(:, 6) + e5(7)*k(:, 7) + e5(8)*k(:, 8) + e5(9)*k(:, 9) + e5(10)*k(:, 10) &
              + e5(11)*k(:, 11) + e5(12)*k(:, 12)
   end function estimate_of_fifth

   !> |e5|²/√(|e5|² + |e3|²/100).
   pure real(wp) function estimate(k, change, fifth, y)
      !> Rates of the stages and the step's increment; shapes (n_rates, 12) and (n_rates).
      real(wp), intent(in) :: k(n_rates, n_stages), change(n_rates)
      !> The difference to the method of order 5; shape (n_rates).
      real(wp), intent(in) :: fifth(n_rates)
      !> Start of the step; shape (n_rates).
      real(wp), intent(in) :: y(n_rates)
      real(wp) :: third(n_rates), last(3), scale, square5, square3
      third = change - (b3(1)*k(:, 1) + b3(2)*k(:, 9) + b3(3)*k(:, 12))
      last = y(5:7) + change(5:7)
      ! A body that starts from rest is measured by what it gains.
      scale = max(y(5)*y(5) + y(6)*y(6) + y(7)*y(7), last(1)*last(1) + last(2)*last(2) + last(3)*last(3))
      if (scale > tiny(1.0_wp)) scale = 1/scale
      square5 = weighted_square(fifth, scale)
      square3 = square5 + 0.01_wp*weighted_square(third, scale)
      estimate = 0.0_wp
      if (square3 > 0.0_wp) estimate = square5/sqrt(square3)
   end function estimate

   !> |2δq|² + |δL|²/|L|².
   pure real(wp) function weighted_square(error, scale)
      real(wp), intent(in) :: error(n_rates)
      !> 1/|L|².
      real(wp), intent(in) :: scale
      weighted_square = 4*(error(1)**2 + error(2)**2 + error(3)**2 + error(4)**2) &
                        + scale*(error(5)**2 + error(6)**2 + error(7)**2)
   end function weighted_square

   !> A step remembers nothing of the ones before.
   subroutine transfer(self, archive)
      class(dop853_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
   end subroutine transfer

end module nutate_dop853
