!> Steps of order 4, 6 and 8 by symmetric composition of the conserving step: S(γ1Δt)∘S(γ2Δt)∘…∘S(γsΔt).
!>
!> Every stage keeps every invariant, so the whole does, at any step. The coefficients are published sets of symmetric
!> compositions of a symmetric second-order method, chosen for their small error constants.
module nutate_composition
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: composition_t, composition_weights_t, compositions

   !> Largest number of stages of a composition up to its middle, the middle included.
   integer, parameter :: half_stages = 9

   !> One symmetric composition.
   type :: composition_weights_t
      integer :: order
      !> Number of stages, odd.
      integer :: stages
      !> γ of the first stages up to the middle one; the rest mirrors them; shape (half_stages).
      real(wp) :: weights(half_stages)
   end type composition_weights_t

   !> Suzuki's γ = 1/(4 - 4^(1/3)).
   real(wp), parameter :: suzuki = 0.41449077179437573714235406286_wp

   !> Order 4: Suzuki, Phys. Lett. A 146 (1990) 319. Orders 6 and 8: Kahan & Li, Math. Comp. 66 (1997) 1089, sets
   !> s9odr6a and s17odr8a.
   type(composition_weights_t), parameter :: compositions(3) = [ &
      composition_weights_t(4, 5, [suzuki, suzuki, 1 - 4*suzuki, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]), &
      composition_weights_t(6, 9, [0.39216144400731413927925056_wp, 0.33259913678935943859974864_wp, &
                                   -0.70624617255763935980996482_wp, 0.08221359629355080023149045_wp, &
                                   0.79854399093482996339895035_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]), &
      composition_weights_t(8, 17, [0.13020248308889008087881763_wp, 0.56116298177510838456196441_wp, &
                                    -0.38947496264484728640807860_wp, 0.15884190655515560089621075_wp, &
                                    -0.39590389413323757733623154_wp, 0.18453964097831570709183254_wp, &
                                    0.25837438768632204729397911_wp, 0.29501172360931029887096624_wp, &
                                    -0.60550853383003451169892108_wp])]

   !> The stepper of one stage: each has its own, whose predictor and Jacobian belong to that stage's length.
   type, private :: stage_t
      class(stepper_t), allocatable :: stepper
      !> γ
      real(wp) :: weight = 0.0_wp
   end type stage_t

   !> A composition of a stepper of order 2. `step` allocates nothing.
   type, extends(stepper_t) :: composition_t
      private
      type(stage_t), allocatable :: stages(:)
      !> State at the start of the step.
      type(state_t), allocatable :: kept
   contains
      !> Sets the stepper to compose; must come before `prepare`.
      procedure :: compose
      procedure :: set_up
      procedure :: advance
      procedure :: forget_steps
      procedure :: transfer
      procedure :: propagate_step
      procedure :: put_memory
      procedure :: take_memory
   end type composition_t

contains

   !> Sets the stepper to compose. Errors: `NUTATE_BAD_ARGUMENT` for an order without a composition.
   subroutine compose(self, base, order, status)
      class(composition_t), intent(inout) :: self
      !> A symmetric stepper of order 2; copied.
      class(stepper_t), intent(in) :: base
      !> 4, 6 or 8.
      integer, intent(in) :: order
      type(status_t), intent(out) :: status
      integer :: i, k
      k = findloc(compositions%order == order, .true., dim=1)
      if (k == 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'no composition has this order (expected 4, 6 or 8)', 'order')
         return
      end if
      if (allocated(self%stages)) deallocate (self%stages)
      associate (n => compositions(k)%stages)
         allocate (self%stages(n))
         do i = 1, n
            allocate (self%stages(i)%stepper, source=base)
            self%stages(i)%weight = compositions(k)%weights(min(i, n + 1 - i))
         end do
      end associate
   end subroutine compose

   !> Prepares the steppers of all stages. Errors: those of the composed stepper's `prepare`; `NUTATE_BAD_ARGUMENT` if
   !> there is none.
   subroutine set_up(self, system, settings, status)
      class(composition_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      integer :: i
      if (.not. allocated(self%stages)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a composition needs a stepper to compose')
         return
      end if
      if (.not. allocated(self%kept)) allocate (self%kept)
      do i = 1, size(self%stages)
         call self%stages(i)%stepper%prepare(system, settings, status)
         if (.not. status%ok()) return
      end do
   end subroutine set_up

   !> Performs all stages of one step. Errors, with the state unchanged: those of a stage.
   subroutine advance(self, system, state, dt, window_time, status)
      class(composition_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      integer :: i, k
      call self%kept%copy_from(state, system%effects%n_wheels, .false.)
      self%iterations = 0
      self%continued = 0
      self%uncertified = 0
      self%residual = 0.0_wp
      self%work = 0.0_wp
      do i = 1, size(self%stages)
         associate (stage => self%stages(i)%stepper)
            call stage%advance(system, state, self%stages(i)%weight*dt, window_time, status)
            self%iterations = self%iterations + stage%iterations
            self%continued = self%continued + stage%continued
            self%uncertified = self%uncertified + stage%uncertified
            self%residual = max(self%residual, stage%residual)
            if (status%code /= 0) exit
            do k = 1, size(self%work)
               self%work(k) = self%work(k) + stage%work(k)
            end do
         end associate
      end do
      status%iterations = self%iterations
      status%residual = self%residual
      if (status%code == 0) then
         state%t = self%kept%t + dt
      else
         call state%copy_from(self%kept, system%effects%n_wheels, .false.)
      end if
   end subroutine advance

   !> Discards the history of steps of all stages.
   recursive subroutine forget_steps(self)
      class(composition_t), intent(inout) :: self
      integer :: i
      do i = 1, size(self%stages)
         call self%stages(i)%stepper%forget_steps()
      end do
   end subroutine forget_steps

   !> Moves sensitivities stage by stage: each stepper still holds its own step.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(composition_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      integer :: i
      do i = 1, size(self%stages)
         call self%stages(i)%stepper%propagate_step(system, before, after, self%stages(i)%weight*dt, window_time, &
                                                  tangent, status)
         if (status%code /= 0) return
      end do
   end subroutine propagate_step

   !> Writes or reads the data that the steppers of all stages keep between steps.
   recursive subroutine transfer(self, archive)
      class(composition_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: i
      do i = 1, size(self%stages)
         call self%stages(i)%stepper%transfer(archive)
      end do
   end subroutine transfer

   !> Writes the data of `transfer` as numbers.
   recursive subroutine put_memory(self, room, numbers, used)
      class(composition_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(inout), target :: numbers(room)
      integer, intent(inout) :: used
      integer :: i
      do i = 1, size(self%stages)
         call self%stages(i)%stepper%put_memory(room, numbers, used)
      end do
   end subroutine put_memory

   !> Reads the data of `transfer` from numbers.
   recursive subroutine take_memory(self, room, numbers, used)
      class(composition_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(in), target :: numbers(room)
      integer, intent(inout) :: used
      integer :: i
      do i = 1, size(self%stages)
         call self%stages(i)%stepper%take_memory(room, numbers, used)
      end do
   end subroutine take_memory

end module nutate_composition
