!> The attack on the true root, shortened, and the oracle that it follows.
submodule(suites_of_methods) test_attack
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_kinds, only: wp
   use test_attack_case, only: attack_case_t, attack_effect_t, changing_one_in, draw_case, effect_kinds, BODY_TORQUE, &
      DAMPING, FEEDBACK, POLYNOMIAL, SPACE_TORQUE, SPRING
   use test_attack_oracle, only: branch_t, oracle_t, ENDED, REACHED
   use test_attack_run, only: attack_case, attack_cases, assess, outcome_t, tally_t, verdict_text
   use test_support, only: check, check_close, error_type, new_unittest, random_vector, share_of
   implicit none

   !> Seed of the shortened attack, its stages, and a third of them.
   integer, parameter :: seed = 1, short = 10000

contains

   module procedure collect_attack
      testsuite = [ &
                  new_unittest("no stage drawn at random takes a wrong root", no_wrong_root), &
                  new_unittest("no body that changes takes a wrong root", changes_keep_their_branch), &
                  new_unittest("a long rod under two torques takes no wrong root", rod_keeps_its_branch), &
                  new_unittest("a spring stepped backwards takes no wrong root", spring_keeps_its_branch), &
                  new_unittest("every kind of case is drawn", draws_are_complete), &
                  new_unittest("the oracle ends a branch where theory says", oracle_ends_at_the_fold), &
                  new_unittest("the oracle follows damping to its fixed rate", oracle_follows_damping), &
                  new_unittest("a wrong root is seen", wrong_root_is_seen)]
   end procedure collect_attack

   !> The bounds are those of `verdict_text`: no wrong root, one trajectory of both solvers, few refusals in vain.
   subroutine no_wrong_root(error)
      type(error_type), allocatable, intent(out) :: error
      type(tally_t) :: tally
      call attack_cases(seed, 1, share_of(short), tally)
      call check(error, verdict_text(tally) == '', verdict_text(tally))
   end subroutine no_wrong_root

   !> Inner spheres and an inertia that varies, by themselves and beside other effects.
   subroutine changes_keep_their_branch(error)
      type(error_type), allocatable, intent(out) :: error
      type(tally_t) :: tally
      call attack_cases(seed, changing_one_in, share_of(short), tally, changing_one_in)
      call check(error, verdict_text(tally) == '', verdict_text(tally))
      associate (all => tally%total())
         call check(error, all%uncertified < 0.5_wp*(all%at_once + all%continued), 'hardly any stage is certified')
      end associate
   end subroutine changes_keep_their_branch

   !> Moments beyond the triangle rule, torques fixed in body and space: the first stage's branch leads elsewhere than
   !> the root next to the prediction.
   subroutine rod_keeps_its_branch(error)
      type(error_type), allocatable, intent(out) :: error
      type(attack_case_t) :: item
      item%moments = [1.0_wp, 100.0_wp, 100.5_wp]
      item%check_triangle = .false.
      item%n_effects = 2
      item%effects(1) = attack_effect_t( &
                        kind=BODY_TORQUE, n=[-1.8216383521852957_wp, -1.1778575678730654_wp, 1.8910543490377683_wp])
      item%effects(2) = attack_effect_t( &
                        kind=SPACE_TORQUE, n=[2.4109384720647618_wp, 0.58184663560249872_wp, -1.4596682718751388_wp])
      item%q = [0.83562161971414317_wp, 0.26742187013768881_wp, 0.19765273771100841_wp, -0.43721327440245494_wp]
      item%omega = [-0.99874798987387203_wp, 0.031045470933011986_wp, -0.039225393018393069_wp]
      item%order = 4
      item%dt = 5.936373826873091_wp
      call check_case(error, item)
   end subroutine rod_keeps_its_branch

   !> A symmetric body and a spring with a rest length: the branch ends at 0.94 of the step.
   subroutine spring_keeps_its_branch(error)
      type(error_type), allocatable, intent(out) :: error
      type(attack_case_t) :: item
      item%moments = [1.0_wp, 1.0001_wp, 2.0_wp]
      item%n_effects = 1
      item%effects(1) = attack_effect_t( &
                        kind=SPRING, m=[0.32237202349974192_wp, 0.36962742859179326_wp, 0.097220586797759342_wp], &
                        n=[0.34541934835100702_wp, -0.30279780852397603_wp, -0.59745807066213996_wp], &
                        strength=16.250658077081759_wp, rest_length=0.91454523028884305_wp)
      item%q = [-0.52120125375685133_wp, 0.4987718610803023_wp, -0.30217348304916791_wp, 0.62311080059545765_wp]
      item%omega = [-0.057260897339943551_wp, -0.35742450840751344_wp, -0.93218501941699938_wp]
      item%dt = -1.3398_wp
      call check_case(error, item)
   end subroutine spring_keeps_its_branch

   !> Checks that the accepted roots of a case are right, the same with both solvers, and known to the oracle.
   subroutine check_case(error, item)
      type(error_type), allocatable, intent(inout) :: error
      type(attack_case_t), intent(in) :: item
      type(tally_t) :: tally
      call attack_case(item, 'this case', tally)
      associate (all => tally%total())
         call check(error, tally%broken == 0 .and. all%unclear == 0 .and. all%stages > 0, 'the case is not assessed')
         call check(error, all%wrong + all%wrong_uncertified + tally%disagreements + &
                    tally%uncertified_disagreements == 0, 'a wrong root, or a difference: '//trim(tally%first))
      end associate
   end subroutine check_case

   !> Checks that each kind of effect, order, direction of time and body is drawn, and each case again from its number
   !> alone.
   subroutine draws_are_complete(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: cases = 1000
      type(attack_case_t) :: item, again
      integer :: kinds(effect_kinds), orders(8), backward, triangle, windows, meeting, bounded(2), number, i
      kinds = 0
      orders = 0
      backward = 0
      triangle = 0
      windows = 0
      meeting = 0
      bounded = 0
      do number = 1, cases
         call draw_case(seed, number, item)
         orders(item%order) = orders(item%order) + 1
         if (item%dt < 0.0_wp) backward = backward + 1
         if (.not. item%check_triangle) triangle = triangle + 1
         do i = 1, item%n_effects
            associate (effect => item%effects(i))
               kinds(effect%kind) = kinds(effect%kind) + 1
               if (effect%stop < huge(1.0_wp)) windows = windows + 1
               if (effect%kind == POLYNOMIAL .and. effect%bounded) bounded(1) = bounded(1) + 1
               if (effect%kind == FEEDBACK .and. effect%bounded) bounded(2) = bounded(2) + 1
               if (effect%kind == SPRING .and. &
                   abs(norm2(effect%m) - norm2(effect%n)) <= 0.01_wp*norm2(effect%n)) meeting = meeting + 1
            end associate
         end do
      end do
      call draw_case(seed, cases, again)
      call check(error, all(kinds > cases/8) .and. all(orders([2, 4, 6, 8]) > cases/12), 'kinds or orders')
      call check(error, abs(backward - cases/5) < cases/20 .and. triangle > cases/20, 'backward steps or bodies')
      call check(error, windows > cases/20 .and. meeting > cases/100, 'windows or springs whose ends meet')
      call check(error, all(3*bounded > kinds([POLYNOMIAL, FEEDBACK]) .and. &
                            3*bounded < 2*kinds([POLYNOMIAL, FEEDBACK])), 'bounds')
      call check_close(error, [again%dt, again%omega, again%moments], [item%dt, item%omega, item%moments], 0.0_wp)
   end subroutine draws_are_complete

   !> A free body on its unstable axis: the branch b = ¼sΩ ends where λs/2 = 1 - |b|², λ the rate of growth.
   subroutine oracle_ends_at_the_fold(error)
      type(error_type), allocatable, intent(out) :: error
      type(attack_case_t) :: item
      type(oracle_t) :: oracle
      type(branch_t) :: branch
      real(wp) :: rate, s
      item%moments = [1.0_wp, 2.0_wp, 2.5_wp]
      item%omega = [0.0_wp, 1.3_wp, 0.0_wp]
      rate = item%omega(2)*sqrt((2.0_wp - 1.0_wp)*(2.5_wp - 2.0_wp)/(1.0_wp*2.5_wp))
      ! (¼sΩ)² + ½λs - 1 = 0
      s = 4*(sqrt(rate**2 + item%omega(2)**2) - rate)/item%omega(2)**2
      call oracle%begin(item, item%q, item%omega, 0.0_wp, 1.25_wp*s, 0.0_wp)
      call oracle%follow(1.0_wp, branch)
      call check(error, branch%outcome == ENDED, 'the branch does not end')
      ! The last increments are 1e-9, where the determinant is round-off of differences.
      call check_close(error, branch%t, 0.8_wp, 1e-4_wp)
      call oracle%begin(item, item%q, item%omega, 0.0_wp, 0.99_wp*s, 0.0_wp)
      call oracle%follow(1.0_wp, branch)
      call check(error, branch%outcome == REACHED, 'the branch ends too early')
      call check_close(error, branch%b, 0.25_wp*0.99_wp*s*item%omega, 1e-9_wp)
   end subroutine oracle_ends_at_the_fold

   !> Damped spin about an axis: (1 - β)(b - b0) + ½s(c/J)(1 - β)b = 0, so b = b0/(1 + ½sc/J).
   subroutine oracle_follows_damping(error)
      type(error_type), allocatable, intent(out) :: error
      type(attack_case_t) :: item
      type(oracle_t) :: oracle
      type(branch_t) :: branch
      real(wp) :: b(3)
      item%moments = [1.0_wp, 2.0_wp, 2.5_wp]
      item%omega = [0.0_wp, 0.0_wp, 1.0_wp]
      item%n_effects = 1
      item%effects(1) = attack_effect_t(kind=DAMPING, m=[0.3_wp, 0.2_wp, 0.5_wp])
      call oracle%begin(item, item%q, item%omega, 0.0_wp, 2.0_wp, 0.0_wp)
      call oracle%follow(1.0_wp, branch)
      b = [0.0_wp, 0.0_wp, 0.5_wp/1.2_wp]
      call check_close(error, branch%b, b, 1e-9_wp)
   end subroutine oracle_follows_damping

   !> The box of scenes/box.nml has several roots at 0.3 s. The branch's own is assessed right and one that Newton's
   !> iteration finds from elsewhere wrong: an attack that sees nothing has not been blind.
   subroutine wrong_root_is_seen(error)
      type(error_type), allocatable, intent(out) :: error
      type(attack_case_t) :: item
      type(oracle_t) :: oracle
      type(branch_t) :: branch
      type(tally_t) :: tally
      real(wp) :: b(3)
      item%moments = [5.0_wp, 20.0_wp, 17.0_wp]
      item%omega = [0.1_wp, 0.0_wp, 10.0_wp]
      call oracle%begin(item, item%q, item%omega, 0.0_wp, 0.3_wp, 0.0_wp)
      call oracle%follow(1.0_wp, branch)
      call find_other_root(oracle, branch%b, b)
      call check(error, branch%outcome == REACHED .and. norm2(b - branch%b) > 0.01_wp, 'no second root')
      call assess(oracle, branch, outcome_t(.true., branch%b, 0, 0), 'full', 1, 1, tally)
      call check(error, tally%counts(1, 1)%wrong == 0 .and. tally%counts(1, 1)%at_once == 1, 'the right root')
      call assess(oracle, branch, outcome_t(.true., b, 0, 0), 'full', 1, 1, tally)
      call assess(oracle, branch, outcome_t(.true., b, 0, 1), 'full', 1, 1, tally)
      call assess(oracle, branch, outcome_t(.false., b, 0, 0), 'full', 1, 1, tally)
      associate (counts => tally%counts(1, 1))
         call check(error, counts%wrong == 1 .and. counts%wrong_uncertified == 1, 'a wrong root is not counted')
         call check(error, counts%too_careful == 1 .and. index(verdict_text(tally), 'as certified (1)') > 0, 'refusal')
      end associate
   end subroutine wrong_root_is_seen

   !> A root of P(b, 1) that is not the one given; that one if none is found.
   subroutine find_other_root(oracle, root, b)
      type(oracle_t), intent(in) :: oracle
      real(wp), intent(in) :: root(3)
      real(wp), intent(out) :: b(3)
      real(wp), parameter :: h = 1e-6_wp
      integer(int64) :: state
      real(wp) :: matrix(3, 3), shift(3)
      integer :: trial, k, i
      state = 4711
      do trial = 1, 1000
         b = 2*random_vector(state)
         do k = 1, 60
            do i = 1, 3
               shift = 0.0_wp
               shift(i) = h
               matrix(:, i) = (oracle%residual(b + shift, 1.0_wp) - oracle%residual(b - shift, 1.0_wp))/(2*h)
            end do
            b = b - solved(matrix, oracle%residual(b, 1.0_wp))
            if (.not. norm2(b) < 10.0_wp) exit
         end do
         ! A solution of the equations at |b| = 1 is not a step.
         if (norm2(b) < 0.95_wp .and. norm2(oracle%residual(b, 1.0_wp)) < 1e-12_wp .and. &
             norm2(b - root) > 0.01_wp) return
      end do
      b = root
   end subroutine find_other_root

   !> x of Ax = f, by Cramer's rule.
   pure function solved(a, f) result(x)
      real(wp), intent(in) :: a(3, 3), f(3)
      real(wp) :: x(3), swapped(3, 3)
      integer :: i
      do i = 1, 3
         swapped = a
         swapped(:, i) = f
         x(i) = determinant(swapped)/determinant(a)
      end do
   end function solved

   pure real(wp) function determinant(a)
      real(wp), intent(in) :: a(3, 3)
      determinant = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) &
                    + a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
   end function determinant

end submodule test_attack
