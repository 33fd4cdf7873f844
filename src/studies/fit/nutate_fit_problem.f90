!> The fit of a scene as a problem of least squares: free parameters and biases against measurements and prior
!> knowledge.
module nutate_fit_problem
   use nutate_attitude, only: rotation_vector_from_quat
   use nutate_fit_model, only: fit_model_t, motion_at_t, switches_t
   use nutate_fit_plan, only: DIRECTIONS
   use nutate_fit_residuals, only: inverse_right_jacobian, residuals_t
   use nutate_kinds, only: wp
   use nutate_least_squares, only: least_squares_problem_t
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_robust_loss, only: LINEAR
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: fit_problem_t

   !> A scene and its measurements up to some time.
   type, extends(least_squares_problem_t) :: fit_problem_t
      type(fit_model_t) :: model
      type(residuals_t), allocatable :: residuals(:)
      !> Names of the parameters: free ones of the scene, then biases; shape (parameters).
      character(len=80), allocatable :: names(:)
      integer :: n_free = 0
      !> Values of the scene, and its attitude, to which `sigma` of a free key refers. Shape (free parameters).
      real(wp), allocatable :: known_values(:)
      real(wp) :: known_attitude(4) = 0.0_wp
      !> Weak prior that keeps short arcs near their initial guess, in use if its deviation is above 0; shape
      !> (parameters).
      real(wp), allocatable :: weak_values(:), weak_sigma(:)
      !> Times of the arc, each once, s; index of each row of each measurement among them, 0 beyond the arc.
      real(wp), allocatable :: times(:)
      integer, allocatable :: places(:, :)
      !> Time at which arcs begin, s: 0, or that of the first measurement if the body has rotated far before.
      real(wp) :: first_time = 0.0_wp
   contains
      !> Prepares for a scene with a fit.
      procedure :: prepare
      !> Uses the measurements up to a time.
      procedure :: set_arc
      !> Returns the number of residuals of measurements in the arc.
      procedure :: measured_in_arc
      procedure :: evaluate
      procedure :: accept => turn_attitude
   end type fit_problem_t

contains

   !> Prepares for a scene with a fit. Errors: those of the model.
   subroutine prepare(self, scene, status)
      class(fit_problem_t), intent(out) :: self
      type(scene_t), intent(in) :: scene
      type(status_t), intent(out) :: status
      integer :: i, k
      character(len=12) :: number
      call self%model%prepare(scene, status)
      if (.not. status%ok()) return
      associate (fit => scene%fit)
         self%n_free = size(fit%free)
         self%names = fit%free%name
         self%known_values = self%model%values
         self%known_attitude = fit%attitude
         self%low = max(fit%free%low, self%model%least)
         self%high = min(fit%free%high, self%model%greatest)
         allocate (self%residuals(size(fit%measurements)))
         do i = 1, size(fit%measurements)
            call self%residuals(i)%prepare(fit%measurements(i), scene%system, &
                                           scene%integrator%inverse_auxiliary_inertia, status)
            if (.not. status%ok()) return
            if (.not. fit%measurements(i)%has_bias) cycle
            write (number, '(".",i0)') i
            if (size(fit%measurements) == 1) number = ''
            self%names = [character(len=len(self%names)) :: self%names, ('measurement'//trim(number)//'.bias.'// &
                          fit%measurements(i)%columns(k), k=1, size(fit%measurements(i)%columns))]
         end do
      end associate
      self%low = [self%low, spread(-huge(1.0_wp), 1, size(self%names) - self%n_free)]
      self%high = [self%high, spread(huge(1.0_wp), 1, size(self%names) - self%n_free)]
      self%sizes = [self%model%sizes, spread(0.0_wp, 1, size(self%names) - self%n_free)]
      self%weak_values = spread(0.0_wp, 1, size(self%names))
      self%weak_sigma = self%weak_values
      call self%set_arc(huge(1.0_wp))
   end subroutine prepare

   !> Uses the measurements up to a time.
   subroutine set_arc(self, length)
      class(fit_problem_t), intent(inout) :: self
      !> Time from the initial time of the run, s.
      real(wp), intent(in) :: length
      integer :: next(size(self%residuals)), i, most
      real(wp) :: t
      logical :: due
      most = maxval([0, (size(self%residuals(i)%measurement%times), i=1, size(self%residuals))])
      if (allocated(self%places)) deallocate (self%places)
      allocate (self%places(most, size(self%residuals)), source=0)
      self%times = [real(wp) ::]
      next = 1
      do
         t = huge(t)
         due = .false.
         do i = 1, size(next)
            associate (times => self%residuals(i)%measurement%times)
               if (next(i) > size(times)) cycle
               if (abs(times(next(i))) < abs(t)) t = times(next(i))
               due = .true.
            end associate
         end do
         if (.not. due .or. abs(t) > length) exit
         self%times = [self%times, t]
         do i = 1, size(next)
            associate (times => self%residuals(i)%measurement%times)
               ! Several rows of a measurement may have the same time.
               do while (next(i) <= size(times))
                  if (abs(times(next(i)) - t) > 0.0_wp) exit
                  self%places(next(i), i) = size(self%times)
                  next(i) = next(i) + 1
               end do
            end associate
         end do
      end do
      ! The measured components of a unit vector have two degrees of freedom.
      self%dependent = sum([(merge(count(self%places(:, i) > 0), 0, self%residuals(i)%measurement%kind == DIRECTIONS), &
                             i=1, size(self%residuals))])
      call set_losses(self)
   end subroutine set_arc

   !> Sets the losses of all residuals: linear for prior knowledge.
   subroutine set_losses(self)
      class(fit_problem_t), intent(inout) :: self
      integer :: i
      if (allocated(self%losses)) deallocate (self%losses)
      if (all([(self%residuals(i)%measurement%loss == LINEAR, i=1, size(self%residuals))])) return
      allocate (self%losses(0))
      do i = 1, size(self%residuals)
         self%losses = [self%losses, spread(self%residuals(i)%measurement%loss, 1, rows_of(self, i))]
      end do
      self%losses = [self%losses, spread(LINEAR, 1, priors(self))]
   end subroutine set_losses

   !> Returns the number of residuals of a measurement in the arc.
   pure integer function rows_of(self, i)
      class(fit_problem_t), intent(in) :: self
      integer, intent(in) :: i
      rows_of = self%residuals(i)%measurement%width()*count(self%places(:, i) > 0)
   end function rows_of

   pure integer function measured_in_arc(self) result(n)
      class(fit_problem_t), intent(in) :: self
      integer :: i
      n = sum([(rows_of(self, i), i=1, size(self%residuals))])
   end function measured_in_arc

   !> Returns the number of residuals of prior knowledge.
   pure integer function priors(self)
      class(fit_problem_t), intent(in) :: self
      priors = count(self%model%plan%free%sigma > 0.0_wp) + count(self%weak_sigma > 0.0_wp)
   end function priors

   !> Computes residuals and Jacobian; the derivative by an attitude is that by a further rotation about the body axes,
   !> as in `accept`. Errors: those of the scene and of the run.
   subroutine evaluate(self, x, residuals, jacobian, status)
      class(fit_problem_t), intent(inout) :: self
      real(wp), intent(in) :: x(:)
      real(wp), allocatable, intent(inout) :: residuals(:), jacobian(:, :)
      type(status_t), intent(out) :: status
      type(motion_at_t) :: motion
      ! System and systems of the stencil, switched as at the time of a measurement.
      type(system_t) :: system
      type(system_t), allocatable :: systems(:, :)
      type(switches_t) :: applied
      integer :: i, k, at, bias, width

      call self%model%set_values(x(:self%n_free), status)
      if (status%ok()) call self%model%build_systems(status)
      if (status%ok()) call self%model%run(self%times, motion, status)
      if (.not. status%ok()) return
      if (allocated(residuals)) deallocate (residuals)
      if (allocated(jacobian)) deallocate (jacobian)
      allocate (residuals(self%measured_in_arc() + priors(self)), source=0.0_wp)
      allocate (jacobian(size(residuals), size(x)), source=0.0_wp)
      at = 0
      bias = self%n_free
      system = self%model%scene%system
      systems = self%model%systems
      do i = 1, size(self%residuals)
         associate (measurement => self%residuals(i)%measurement)
            width = measurement%width()
            do k = 1, size(measurement%times)
               if (self%places(k, i) == 0) exit
               associate (t => self%places(k, i))
                  call switch_systems(motion%switches(t), self%model%changes_system, applied, system, systems)
                  call self%residuals(i)%evaluate(k, system, systems, self%model%weights, self%model%changes_system, &
                                                  motion%states(t), motion%sensitivities(:, :, t), &
                                                  residuals(at + 1:at + width), &
                                                  jacobian(at + 1:at + width, :self%n_free))
               end associate
               if (measurement%has_bias) call add_bias(x, bias, measurement%sigma, residuals(at + 1:at + width), &
                                                       jacobian(at + 1:at + width, :))
               at = at + width
            end do
            if (measurement%has_bias) bias = bias + width
         end associate
      end do
      call add_knowledge(self, x, residuals(at + 1:), jacobian(at + 1:, :))
   end subroutine evaluate

   !> Switches the effects of the systems, unless the switches are those of the last time.
   subroutine switch_systems(switches, changes_system, applied, system, systems)
      type(switches_t), intent(in) :: switches
      !> True for a parameter with systems; shape (free parameters).
      logical, intent(in) :: changes_system(:)
      !> Switches of the last time.
      type(switches_t), intent(inout) :: applied
      type(system_t), intent(inout) :: system
      !> Systems of the stencil; shape (points, free parameters).
      type(system_t), intent(inout) :: systems(:, :)
      integer :: i, k
      if (.not. allocated(switches%bytes)) return
      if (allocated(applied%bytes)) then
         if (applied%bytes == switches%bytes) return
      end if
      applied%bytes = switches%bytes
      call switches%apply(system%effects)
      do i = 1, size(changes_system)
         if (.not. changes_system(i)) cycle
         do k = 1, size(systems, 1)
            call switches%apply(systems(k, i)%effects)
         end do
      end do
   end subroutine switch_systems

   !> Adds the biases to the residuals of a row.
   pure subroutine add_bias(x, bias, sigma, residuals, jacobian)
      real(wp), intent(in) :: x(:)
      !> Number of parameters before the biases.
      integer, intent(in) :: bias
      real(wp), intent(in) :: sigma(:)
      real(wp), intent(inout) :: residuals(:), jacobian(:, :)
      integer :: i
      do i = 1, size(residuals)
         residuals(i) = residuals(i) + x(bias + i)/sigma(i)
         jacobian(i, bias + i) = 1/sigma(i)
      end do
   end subroutine add_bias

   !> Adds the residuals of prior knowledge: of free parameters with a standard deviation, and the weak prior of short
   !> arcs.
   subroutine add_knowledge(self, x, residuals, jacobian)
      class(fit_problem_t), intent(in) :: self
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: residuals(:), jacobian(:, :)
      real(wp) :: e(3), matrix(3, 3), unit
      integer :: i, k, at
      at = 0
      unit = self%model%plan%angle_unit
      associate (free => self%model%plan%free)
         if (self%model%plan%has_attitude) then
            e = rotation_vector_from_quat(quat_product(quat_conjugate(self%known_attitude), &
               self%model%attitude_at(self%model%turn_of(x))))
            matrix = inverse_right_jacobian(e)
         end if
         do i = 1, size(free)
            if (.not. free(i)%sigma > 0.0_wp) cycle
            at = at + 1
            if (free(i)%component > 0) then
               residuals(at) = e(free(i)%component)/(unit*free(i)%sigma)
               do k = 1, size(free)
                  if (free(k)%component > 0) jacobian(at, k) = matrix(free(i)%component, &
                     free(k)%component)/free(i)%sigma
               end do
            else
               residuals(at) = (x(i) - self%known_values(i))/free(i)%sigma
               jacobian(at, i) = 1/free(i)%sigma
            end if
         end do
      end associate
      do i = 1, size(x)
         if (.not. self%weak_sigma(i) > 0.0_wp) cycle
         at = at + 1
         residuals(at) = (x(i) - self%weak_values(i))/self%weak_sigma(i)
         jacobian(at, i) = 1/self%weak_sigma(i)
      end do
   end subroutine add_knowledge

   !> Makes the present attitude the origin of rotation vectors.
   subroutine turn_attitude(self, x)
      class(fit_problem_t), intent(inout) :: self
      real(wp), intent(inout) :: x(:)
      call self%model%turn_attitude(x(:self%n_free))
   end subroutine turn_attitude

end module nutate_fit_problem
