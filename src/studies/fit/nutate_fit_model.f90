!> A scene as a function of its free parameters: the motion at given times, and its derivative with respect to each.
module nutate_fit_model
   use nutate_admissible, only: NON_NEGATIVE
   use nutate_attitude, only: quat_from_rotation_vector
   use nutate_byte_archive, only: byte_archive_t
   use nutate_variation, only: variation_t
   use nutate_effect_list, only: effect_list_t
   use nutate_event_list, only: event_list_t
   use nutate_fit_variations, only: add_key, add_scene, one_sided_places, one_sided_weights, places, weights
   use nutate_fit_plan, only: fit_plan_t
   use nutate_hamiltonian, only: body_momentum, system_t
   use nutate_keys, only: group_t, setting_t, KEY_LOGICAL
   use nutate_kinds, only: wp, long, pi
   use nutate_method_choice, only: choose_with_tangent
   use nutate_quaternion, only: quat_normalized, quat_product
   use nutate_run, only: observer_t, run_record_t, run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: changed_part, rebuild_scene, scene_t
   use nutate_scene_error, only: scene_error_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_SCENE, NUTATE_STEP_LIMIT, &
      NUTATE_STOPPED
   use nutate_tangent, only: check_effects
   implicit none
   private

   public :: fit_model_t, motion_at_t, move_state, switches_t

   !> Switches of the effects at a time, in a motion in which events switch some.
   type :: switches_t
      !> Checkpoint data of the effects; not allocated if nothing switches.
      character(len=:), allocatable :: bytes
   contains
      !> Switches the effects of a system, which has the same as the motion.
      procedure :: apply => apply_switches
   end type switches_t

   !> The motion at given times.
   type :: motion_at_t
      !> Shape (times).
      type(state_t), allocatable :: states(:)
      !> Derivative of each state with respect to each free parameter: rotation vector and momentum in body axes, and
      !> the momenta of wheels. Shape (6 + wheels, free parameters, times).
      real(wp), allocatable :: sensitivities(:, :, :)
      !> Switches of the effects; shape (times).
      type(switches_t), allocatable :: switches(:)
   end type motion_at_t

   !> A scene with free parameters.
   type :: fit_model_t
      !> Scene with the present parameters, without its fit.
      class(scene_t), allocatable :: scene
      type(fit_plan_t) :: plan
      !> Present value of each free parameter; components of an attitude are 0. Shape (free parameters).
      real(wp), allocatable :: values(:)
      !> True if the system depends on the parameter; shape (free parameters).
      logical, allocatable :: changes_system(:)
      !> Systems at the points of the stencil, for each free parameter that the system depends on.
      type(system_t), allocatable :: systems(:, :)
      !> Sizes of the parameters in the scene, and the least and the greatest values that their keys admit; shape
      !> (parameters).
      real(wp), allocatable :: sizes(:), least(:), greatest(:)
      !> Points of the stencil, from the present values, and their weights; shape (points, parameters).
      real(wp), allocatable :: offsets(:, :), weights(:, :)
      !> Part of the scene that is rebuilt for each change of the parameters.
      integer, private :: part = 0
      !> Steps that runs with derivatives may still perform: `max_steps` of the scene's plan limits their sum.
      integer(long), private :: steps_left = huge(1_long)
      !> Steps of the longest of these runs that came to its end.
      integer(long), private :: most_steps = 0
      !> Initial time of runs, s.
      real(wp) :: origin = 0.0_wp
      !> Number of runs with derivatives so far.
      integer :: runs = 0
      !> Observer polled before and in each run; null for none.
      class(observer_t), pointer :: polled => null()
   contains
      !> Prepares for a scene with a fit.
      procedure, non_overridable :: prepare
      !> Prepares for a scene with free parameters, if only `variation_of` is called.
      procedure, non_overridable :: begin
      !> Returns what a free parameter changes.
      procedure, non_overridable :: variation_of
      !> Sets the free parameters, and builds the scene with them.
      procedure, non_overridable :: set_values
      !> Sets the time at which runs start from the values of `&initial`.
      procedure, non_overridable :: set_origin
      !> Makes the present attitude the origin of rotation vectors.
      procedure, non_overridable :: turn_attitude
      !> Returns the groups of the scene with the present parameters.
      procedure, non_overridable :: present_groups
      !> Returns the attitude that a rotation vector leads to.
      procedure, non_overridable :: attitude_at
      !> Returns the rotation vector among the parameters.
      procedure, non_overridable :: turn_of
      !> Builds the systems at the points of the stencil.
      procedure, non_overridable :: build_systems
      !> Runs the scene with its derivatives.
      procedure, non_overridable :: run
      !> Returns the motion at given times, without derivatives.
      procedure, non_overridable :: states_at
   end type fit_model_t

   !> Observer that keeps the motion of a run at given times.
   type, extends(observer_t) :: keeper_t
      real(wp), allocatable :: times(:)
      type(motion_at_t) :: motion
      !> True if events switch effects.
      logical :: is_switched = .false.
      integer :: n = 0
      !> Observer that is polled before the run and in it; null for none.
      class(observer_t), pointer :: polled => null()
   contains
      procedure :: poll => poll_stop
      procedure :: observe => keep_state
   end type keeper_t

   !> Step of the stencil relative to the size of the parameter, or to 1 if it has none.
   real(wp), parameter :: relative_step = 1e-3_wp
   !> A run that needs so many times the steps of earlier runs has parameters far from all measurements: an inertia near
   !> 0, a body that spins a thousand times as fast.
   integer(long), parameter :: too_many = 100
   !> Share of the largest of several differences below which a difference is rounding.
   real(wp), parameter :: negligible = 1e-11_wp
   character(len=*), parameter :: triangle_key = 'check_triangle'
   character(len=*), parameter :: window_keys(2) = [character(len=5) :: 'start', 'stop']
   !> Groups whose changes of initial state and body are differentiated; effects compute their own derivatives.
   character(len=*), parameter :: differentiated(4) = [character(len=24) :: 'initial', 'body', 'rotor', &
      'rotating_frame']

contains

   !> Prepares for a scene with a fit. Errors: `NUTATE_BAD_ARGUMENT` for a motion that has no derivative.
   subroutine prepare(self, scene, status)
      class(fit_model_t), intent(out) :: self
      type(scene_t), intent(in) :: scene
      type(status_t), intent(out) :: status
      call check_effects(scene%system%effects, status)
      if (.not. status%ok()) return
      call self%begin(scene)
      self%steps_left = scene%plan%max_steps
      self%scene%plan%max_steps = huge(1_long)
      call choose_with_tangent(self%scene%plan%goal%active(), self%scene%integrator, self%scene%system, &
                               self%scene%initial)
   end subroutine prepare

   !> Prepares for a scene with free parameters.
   subroutine begin(self, scene)
      class(fit_model_t), intent(out) :: self
      type(scene_t), intent(in) :: scene
      integer :: i
      if (allocated(self%scene)) deallocate (self%scene)
      allocate (self%scene, source=scene)
      call forget(self%scene%fit)
      self%plan = scene%fit
      self%scene%groups = scene%fit%numbers%groups
      self%scene%integrator%attitude = .true.
      call lift_triangle(self%scene)
      associate (numbers => scene%fit%numbers, free => scene%fit%free)
         self%part = changed_part(numbers%groups, [(any(numbers%targets%group == i) .or. &
                                                    (scene%fit%has_attitude .and. &
                                                       numbers%groups(i)%name == 'initial'), &
                                                    i=1, size(numbers%groups))])
         allocate (self%values(size(free)), source=0.0_wp)
         allocate (self%changes_system(size(free)), source=.false.)
         do i = 1, size(free)
            if (free(i)%target == 0) cycle
            associate (target => numbers%targets(free(i)%target))
               ! The times at which torques act change the motion alone.
               self%changes_system(i) = numbers%groups(target%group)%name /= 'initial' .and. &
                                        all(target%key%name /= window_keys)
               self%values(i) = numbers%groups(target%group)%settings(target%setting)%values(target%value)%number
            end associate
         end do
         self%sizes = [(size_of(self, i), i=1, size(free))]
      end associate
      call find_range(self)
      call choose_stencils(self)
   end subroutine begin

   !> Finds the least and the greatest values that the keys of the parameters admit.
   subroutine find_range(self)
      class(fit_model_t), intent(inout) :: self
      integer :: i
      allocate (self%least(size(self%values)), source=-huge(1.0_wp))
      allocate (self%greatest(size(self%values)), source=huge(1.0_wp))
      do i = 1, size(self%values)
         if (self%plan%free(i)%target == 0) cycle
         associate (target => self%plan%numbers%targets(self%plan%free(i)%target))
            if (target%key%range == NON_NEGATIVE) self%least(i) = 0.0_wp
            if (target%key%name /= 'pole' .or. target%value /= 2) cycle
            self%greatest(i) = pi/2/self%plan%angle_unit
            self%least(i) = -self%greatest(i)
         end associate
      end do
   end subroutine find_range

   !> Chooses the stencils at the present values: central differences, or one-sided ones next to the limit of a key.
   subroutine choose_stencils(self)
      class(fit_model_t), intent(inout) :: self
      real(wp) :: step
      integer :: i
      if (.not. allocated(self%offsets)) &
         allocate (self%offsets(size(places), size(self%values)), self%weights(size(places), size(self%values)))
      do i = 1, size(self%values)
         step = relative_step*merge(self%sizes(i), 1.0_wp, self%sizes(i) > 0.0_wp)
         self%offsets(:, i) = places*step
         self%weights(:, i) = weights/step
         if (self%values(i) - 2*step >= self%least(i) .and. self%values(i) + 2*step <= self%greatest(i)) cycle
         if (self%values(i) + 2*step > self%greatest(i)) step = -step
         self%offsets(:, i) = one_sided_places*step
         self%weights(:, i) = one_sided_weights/step
      end do
   end subroutine choose_stencils

   !> Empties the plan of a fit.
   subroutine forget(plan)
      type(fit_plan_t), intent(out) :: plan
   end subroutine forget

   !> Returns the size of a parameter: the largest value of its key in the scene, 1 rad for a rotation; 0 if all are
   !> zero.
   pure real(wp) function size_of(self, i)
      class(fit_model_t), intent(in) :: self
      integer, intent(in) :: i
      size_of = 1/self%plan%angle_unit
      if (self%plan%free(i)%target == 0) return
      associate (target => self%plan%numbers%targets(self%plan%free(i)%target))
         size_of = maxval(abs(self%plan%numbers%groups(target%group)%settings(target%setting)%values%number))
      end associate
   end function size_of

   !> Sets the free parameters, and builds the scene with them. Errors: `NUTATE_BAD_SCENE`, or a more specific code, if
   !> the scene rejects a value.
   subroutine set_values(self, values, status)
      class(fit_model_t), intent(inout) :: self
      !> Values of the parameters; rotation vectors count from the present attitude. Shape (free parameters).
      real(wp), intent(in) :: values(:)
      type(status_t), intent(out) :: status
      self%values = values
      call choose_stencils(self)
      call put_values(self, self%attitude_at(self%turn_of(values)), values, self%scene, status)
   end subroutine set_values

   !> Builds a scene with given parameters.
   subroutine put_values(self, attitude, values, scene, status)
      class(fit_model_t), intent(in) :: self
      !> Attitude, used if it is free.
      real(wp), intent(in) :: attitude(4)
      !> Values of the parameters; components of the attitude are ignored. Shape (free parameters).
      real(wp), intent(in) :: values(:)
      type(scene_t), intent(inout) :: scene
      type(status_t), intent(out) :: status
      type(scene_error_t) :: error
      character(len=:), allocatable :: fault
      integer :: i, k
      do i = 1, size(values)
         if (self%plan%free(i)%component > 0) cycle
         associate (target => self%plan%numbers%targets(self%plan%free(i)%target))
            scene%groups(target%group)%settings(target%setting)%values(target%value)%number = values(i)
            fault = target%key%fault(values(i))
            if (fault /= '') call error%raise(0, trim(target%name)//' '//fault)
         end associate
      end do
      if (self%plan%has_attitude) then
         i = findloc(scene%groups%name == 'initial', .true., dim=1)
         k = findloc(scene%groups(i)%settings%name == 'quaternion', .true., dim=1)
         scene%groups(i)%settings(k)%values%number = attitude
      end if
      if (.not. error%raised) call rebuild_scene(scene, self%part, error)
      scene%integrator%attitude = .true.
      if (.not. error%raised) return
      if (error%code == NUTATE_BAD_ARGUMENT) error%code = NUTATE_BAD_SCENE
      status = fail(error%code, error%text)
   end subroutine put_values

   !> Returns the rotation vector among the parameters, rad; shape (3).
   pure function turn_of(self, values) result(turn)
      class(fit_model_t), intent(in) :: self
      real(wp), intent(in) :: values(:)
      real(wp) :: turn(3)
      integer :: i
      turn = 0.0_wp
      do i = 1, size(self%plan%free)
         if (self%plan%free(i)%component > 0) turn(self%plan%free(i)%component) = self%plan%angle_unit*values(i)
      end do
   end function turn_of

   !> Returns the attitude that a rotation vector leads to, as the scene gives it; shape (4).
   pure function attitude_at(self, turn) result(q)
      class(fit_model_t), intent(in) :: self
      !> Rotation vector, body axes, rad.
      real(wp), intent(in) :: turn(3)
      real(wp) :: q(4)
      q = quat_normalized(quat_product(self%plan%attitude, quat_from_rotation_vector(turn)))
   end function attitude_at

   !> Sets the time at which runs start from the values of `&initial`, s, and discards the numbers of steps of earlier
   !> runs.
   subroutine set_origin(self, origin)
      class(fit_model_t), intent(inout) :: self
      real(wp), intent(in) :: origin
      self%origin = origin
      self%most_steps = 0
   end subroutine set_origin

   !> Makes the present attitude the origin of rotation vectors.
   subroutine turn_attitude(self, values)
      class(fit_model_t), intent(inout) :: self
      !> Values of the parameters, shape (free parameters); the components of the attitude become 0.
      real(wp), intent(inout) :: values(:)
      self%plan%attitude = self%attitude_at(self%turn_of(values))
      where (self%plan%free%component > 0) values = 0.0_wp
      self%values = values
   end subroutine turn_attitude

   !> Builds the scene at a point of the stencil of a parameter; a rotation continues from the present attitude. The
   !> moments of a plate may break the triangle inequality there.
   subroutine build_beside(self, i, k, scene, status)
      class(fit_model_t), intent(in) :: self
      !> Indices of the parameter and of the point.
      integer, intent(in) :: i, k
      type(scene_t), intent(inout) :: scene
      type(status_t), intent(out) :: status
      real(wp) :: values(size(self%values)), turn(3), q(4)
      values = self%values
      values(i) = values(i) + self%offsets(k, i)
      q = self%attitude_at(self%turn_of(self%values))
      turn = 0.0_wp
      if (self%plan%free(i)%component > 0) then
         turn(self%plan%free(i)%component) = self%plan%angle_unit*self%offsets(k, i)
         q = quat_normalized(quat_product(q, quat_from_rotation_vector(turn)))
      end if
      scene = self%scene
      call put_values(self, q, values, scene, status)
   end subroutine build_beside

   !> Lets moments break the triangle inequality.
   subroutine lift_triangle(scene)
      type(scene_t), intent(inout) :: scene
      type(setting_t) :: setting
      integer :: i
      i = findloc(scene%groups%name == 'body', .true., dim=1)
      setting%name = triangle_key
      setting%kind = KEY_LOGICAL
      allocate (setting%values(1))
      call scene%groups(i)%put(setting)
   end subroutine lift_triangle

   !> Returns the groups of the scene with the present parameters, and with the original check of the triangle
   !> inequality.
   function present_groups(self) result(groups)
      class(fit_model_t), intent(in) :: self
      type(group_t), allocatable :: groups(:)
      integer :: i, k
      groups = self%scene%groups
      i = findloc(groups%name == 'body', .true., dim=1)
      associate (given => self%plan%numbers%groups(i)%settings)
         k = findloc(given%name == triangle_key, .true., dim=1)
         call groups(i)%drop(triangle_key)
         if (k > 0) call groups(i)%put(given(k))
      end associate
   end function present_groups

   !> Builds the systems at the points of the stencil. Errors: those of the scene.
   subroutine build_systems(self, status)
      class(fit_model_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      class(scene_t), allocatable :: scene
      integer :: i, k
      allocate (scene)
      if (allocated(self%systems)) deallocate (self%systems)
      allocate (self%systems(size(places), size(self%values)))
      do i = 1, size(self%values)
         if (.not. self%changes_system(i)) cycle
         do k = 1, size(places)
            call build_beside(self, i, k, scene, status)
            if (.not. status%ok()) return
            self%systems(k, i) = scene%system
         end do
      end do
   end subroutine build_systems

   !> Runs the scene with its derivatives. Errors: those of the run; `NUTATE_BAD_ARGUMENT` for a parameter with respect
   !> to which the motion has no derivative; `NUTATE_STOPPED` if all runs together need more steps than the plan allows;
   !> `NUTATE_STEP_LIMIT` for parameters with which a run needs `too_many` times the steps of earlier runs.
   subroutine run(self, times, motion, status)
      class(fit_model_t), intent(inout) :: self
      !> Times in the order of the run, s; shape (times).
      real(wp), intent(in) :: times(:)
      type(motion_at_t), intent(out) :: motion
      type(status_t), intent(out) :: status
      type(variation_t), allocatable :: variations(:)
      call make_variations(self, variations, status)
      if (.not. status%ok()) return
      self%runs = self%runs + 1
      call go(self%scene, self%origin, times, self%polled, motion, status, self%steps_left, &
              self%most_steps, variations)
   end subroutine run

   !> Returns the motion at given times, without derivatives. Errors: those of the run.
   subroutine states_at(self, times, motion, status)
      class(fit_model_t), intent(in) :: self
      !> Times in the order of the run, s; shape (times).
      real(wp), intent(in) :: times(:)
      type(motion_at_t), intent(out) :: motion
      type(status_t), intent(out) :: status
      call go(self%scene, self%origin, times, self%polled, motion, status)
   end subroutine states_at

   !> Finds what each free parameter changes. Errors: `NUTATE_BAD_ARGUMENT` if the motion has no derivative by one of
   !> them.
   subroutine make_variations(self, variations, status)
      class(fit_model_t), intent(in) :: self
      type(variation_t), allocatable, intent(out) :: variations(:)
      type(status_t), intent(out) :: status
      integer :: i
      allocate (variations(size(self%values)))
      do i = 1, size(variations)
         call self%variation_of(i, variations(i), status)
         if (.not. status%ok()) return
      end do
   end subroutine make_variations

   !> Returns what a free parameter changes. Errors: `NUTATE_BAD_ARGUMENT` if the motion has no derivative by it.
   subroutine variation_of(self, i, variation, status)
      class(fit_model_t), intent(in) :: self
      !> Index of the free parameter.
      integer, intent(in) :: i
      type(variation_t), intent(out) :: variation
      type(status_t), intent(out) :: status
      class(scene_t), allocatable :: scene
      character(len=24) :: group
      integer :: k
      allocate (scene)
      variation%name = self%plan%free(i)%name
      group = ''
      if (self%plan%free(i)%target > 0) then
         associate (target => self%plan%numbers%targets(self%plan%free(i)%target))
            group = self%scene%groups(target%group)%name
            ! The factor of a table changes the inertia at all times.
            if (all(group /= differentiated) .or. target%key%name == 'inertia_scale') then
               call add_key(self%scene, target%group, target%key%name, target%value, &
                            size(self%scene%groups(target%group)%settings(target%setting)%values), target%name, &
                            variation, status)
               return
            end if
         end associate
      end if
      do k = 1, size(places)
         call build_beside(self, i, k, scene, status)
         if (.not. status%ok()) return
         call add_scene(group, self%scene, scene, self%weights(k, i), variation)
      end do
      ! Elements that differ from zero by rounding only.
      where (abs(variation%inertia) < negligible*maxval(abs(variation%inertia))) variation%inertia = 0.0_wp
   end subroutine variation_of

   !> Runs a scene and keeps the motion at given times.
   subroutine go(scene, origin, times, polled, motion, status, steps_left, most_steps, variations)
      type(scene_t), intent(in) :: scene
      !> Initial time of the run, s.
      real(wp), intent(in) :: origin
      real(wp), intent(in) :: times(:)
      class(observer_t), pointer, intent(in) :: polled
      type(motion_at_t), intent(out) :: motion
      type(status_t), intent(out) :: status
      !> Steps that the run may perform; on return without those performed.
      integer(long), intent(inout), optional :: steps_left
      !> Steps of the longest run that came to its end; 0 if none has.
      integer(long), intent(inout), optional :: most_steps
      !> Variations whose derivatives are required.
      type(variation_t), intent(in), optional :: variations(:)
      type(keeper_t) :: keeper
      type(event_list_t) :: events
      type(run_plan_t) :: plan
      type(run_t) :: run
      type(state_t) :: start
      start = scene%initial
      start%t = origin
      plan = scene%plan
      plan%times = times
      plan%end_time = times(size(times))
      ! Columns begin with the state.
      if (.not. abs(plan%end_time - origin) > 0.0_wp) plan%end_time = origin + scene%plan%end_time
      plan%time_step = sign(plan%time_step, plan%end_time - origin)
      if (present(steps_left)) then
         plan%max_steps = steps_left
         if (most_steps > 0) plan%max_steps = min(steps_left, too_many*max(most_steps, 10_long))
      end if
      allocate (keeper%motion%states(size(times)), keeper%motion%switches(size(times)))
      keeper%times = times
      keeper%polled => polled
      call list_switches(scene%events, events)
      keeper%is_switched = events%count() > 0
      if (present(variations)) then
         keeper%wants_tangent = .true.
         allocate (keeper%motion%sensitivities(6 + scene%system%effects%n_wheels, size(variations), size(times)))
      end if
      call run%begin(scene%system, scene%integrator, start, plan, status)
      if (status%ok() .and. keeper%is_switched) call run%set_events(events, scene%system, status)
      if (status%ok() .and. present(variations)) call run%differentiate(variations, scene%system, status)
      ! Short runs do not poll.
      if (status%ok()) call keeper%poll(0.0_wp, status)
      if (status%ok()) call run%run_to_end(scene%system, status, keeper)
      if (status%ok() .and. keeper%n < size(times)) &
         status = fail(NUTATE_BAD_SCENE, 'the run ended before the last measurement')
      if (present(steps_left)) then
         steps_left = max(0_long, steps_left - run%summary%parts)
         if (status%ok()) most_steps = max(most_steps, run%summary%parts)
         if (status%code == NUTATE_STEP_LIMIT .and. steps_left == 0) &
            status = fail(NUTATE_STOPPED, 'the fit needs more steps than allowed')
      end if
      call move_alloc(keeper%motion%states, motion%states)
      call move_alloc(keeper%motion%switches, motion%switches)
      if (present(variations)) call move_alloc(keeper%motion%sensitivities, motion%sensitivities)
   end subroutine go

   !> Lists the events that switch effects. They do not end the run: it continues to the last measurement.
   subroutine list_switches(events, switches)
      type(event_list_t), intent(in) :: events
      type(event_list_t), intent(inout) :: switches
      integer :: i
      do i = 1, events%count()
         if (events%slots(i)%item%action == 0) cycle
         call switches%add(events%slots(i)%item)
         switches%slots(switches%count())%item%stop = .false.
      end do
   end subroutine list_switches

   !> Switches the effects of a system, which has the same as the motion.
   subroutine apply_switches(self, effects)
      class(switches_t), intent(in) :: self
      type(effect_list_t), intent(inout) :: effects
      type(byte_archive_t) :: archive
      if (.not. allocated(self%bytes)) return
      call archive%begin_reading(self%bytes)
      call effects%transfer_switches(archive)
   end subroutine apply_switches

   !> Polls the observer of the fit, which may end the run.
   subroutine poll_stop(self, fraction, status)
      class(keeper_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      if (associated(self%polled)) call self%polled%poll(fraction, status)
   end subroutine poll_stop

   !> Keeps a state that is due.
   subroutine keep_state(self, system, state, record, status)
      class(keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (self%n >= size(self%times)) return
      if (abs(state%t - self%times(self%n + 1)) > 0.0_wp) return
      self%n = self%n + 1
      self%motion%states(self%n) = state
      if (self%is_switched) call keep_switches(system%effects, self%motion%switches(self%n)%bytes)
      if (.not. allocated(self%motion%sensitivities)) return
      self%motion%sensitivities(1:3, :, self%n) = transpose(self%tangent%theta)
      self%motion%sensitivities(4:6, :, self%n) = transpose(self%tangent%momentum)
      self%motion%sensitivities(7:, :, self%n) = transpose(self%tangent%wheels)
   end subroutine keep_state

   !> Keeps the switches of the effects.
   subroutine keep_switches(effects, bytes)
      type(effect_list_t), intent(in) :: effects
      character(len=:), allocatable, intent(out) :: bytes
      type(effect_list_t) :: own
      type(byte_archive_t) :: archive
      own = effects
      call archive%begin_writing()
      call own%transfer_switches(archive)
      bytes = archive%content()
   end subroutine keep_switches

   !> Moves a copy of a state by a change of attitude and momenta.
   pure subroutine move_state(state, change, moved)
      type(state_t), intent(in) :: state
      !> Rotation vector and momentum, body axes, and momenta of wheels; shape (6 + wheels).
      real(wp), intent(in) :: change(:)
      !> Copy of the state, which may have been moved before.
      type(state_t), intent(inout) :: moved
      real(wp) :: momentum(3)
      momentum = body_momentum(state) + change(4:6)
      moved%q = quat_product(state%q, quat_from_rotation_vector(change(1:3)))
      moved%p = 2*quat_product(moved%q, [0.0_wp, momentum])
      moved%wheel_momentum(:size(change) - 6) = state%wheel_momentum(:size(change) - 6) + change(7:)
   end subroutine move_state

end module nutate_fit_model
