!> Members of an ensemble that are run together, each in a lane, by Taylor series with fixed steps:
!> gyrostats, tops and satellites. Their rows have the bits of members that are run alone.
module nutate_lane_run
   use nutate_columns, only: columns_t
   use nutate_fixed_steps, only: count_steps
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, long
   use nutate_limits, only: same_time
   use nutate_member_watcher, only: look_stride
   use nutate_observer, only: run_record_t
   use nutate_row_layout, only: bits_of, row_layout_t
   use nutate_scene, only: scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_OK, NUTATE_STOPPED
   use nutate_stepper, only: integrator_settings_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_system, only: system_t
   use nutate_taylor_lanes, only: can_be_lanes, lanes, taylor_lanes_t
   implicit none
   private

   public :: lane_run_t, lanes, batch_obstacle

   !> Steps between two questions whether to go on.
   integer(long), parameter :: poll_every = 1024
   !> Steps of which the times are told from each other without doubt.
   integer(long), parameter :: most_steps = 10000000_long

   !> One member under way.
   type :: lane_member_t
      type(system_t) :: system
      type(state_t) :: state
      type(columns_t) :: columns
      type(invariants_t) :: invariants
      !> The numbers in which it differs; shape (targets).
      real(wp), allocatable :: values(:)
   end type lane_member_t

   !> Members that are run together.
   type :: lane_run_t
      !> Those of the scene can be.
      logical :: possible = .false.
      !> Of each lane; shape (lanes).
      type(lane_member_t), allocatable, private :: members(:)
      type(taylor_lanes_t), allocatable, private :: bodies
      integer(long), private :: steps = 0
      !> Steps after which members are looked at.
      integer(long), private :: stride = 1
   contains
      !> Prepares for a scene with an ensemble.
      procedure :: prepare
      !> Empties all lanes.
      procedure :: begin
      !> Puts a member into a lane.
      procedure :: join
      !> Runs all to their end.
      procedure :: run
      !> The row of a lane.
      procedure :: write_row
      !> A lane has come to its end.
      procedure :: arrived
   end type lane_run_t

contains

   !> Prepares for a scene with an ensemble.
   subroutine prepare(self, scene, columns)
      class(lane_run_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      !> Chosen.
      type(columns_t), intent(in) :: columns
      self%possible = batch_obstacle(scene, columns) == ''
      if (.not. self%possible) return
      self%steps = count_steps(scene%initial%t, scene%plan)
      self%stride = max(scene%plan%every, look_stride(scene))
      if (allocated(self%bodies)) return
      allocate (self%members(lanes))
      allocate (self%bodies)
   end subroutine prepare

   !> What keeps all members of a scene out of batches, in words; empty if nothing does.
   function batch_obstacle(scene, columns) result(words)
      !> With an ensemble.
      type(scene_t), intent(in) :: scene
      !> Chosen.
      type(columns_t), intent(in) :: columns
      character(len=:), allocatable :: words
      words = method_obstacle(scene%integrator)
      if (words == '') words = steps_obstacle(scene)
      if (words /= '') return
      if (.not. can_be_lanes(scene%system)) then
         words = 'an effect that batches do not support'
         associate (effects => scene%system%effects)
            if (effects%n_potentials + effects%n_off + effects%n_torques + effects%n_wheels == 0 .and. &
                .not. effects%frame_turns) words = "a free body has a closed solution, method = 'exact'"
         end associate
      else if (scene%events%count() > 0) then
         words = 'there are events'
      else if (columns%follows_steps) then
         words = 'there are Euler angles among the columns'
      else if (any(scene%output%columns == 'solver')) then
         words = "'solver' is among the columns"
      end if
   end function batch_obstacle

   !> What of a method and its settings lanes do not know.
   pure function method_obstacle(settings) result(words)
      type(integrator_settings_t), intent(in) :: settings
      character(len=:), allocatable :: words
      words = ''
      if (settings%method /= 'taylor') then
         words = "method is '"//trim(settings%method)//"'"
      else if (.not. settings%conserve) then
         words = 'conserve is off'
      else if (.not. settings%attitude) then
         words = 'no column depends on the attitude'
      end if
   end function method_obstacle

   !> Why not all members take the same fixed steps, the last one as long as the others; empty if they do.
   pure function steps_obstacle(scene) result(words)
      type(scene_t), intent(in) :: scene
      character(len=:), allocatable :: words
      integer(long) :: n
      words = ''
      associate (plan => scene%plan)
         if (plan%goal%active()) then
            words = 'steps are adaptive'
         else if (allocated(plan%times) .or. plan%interval > 0.0_wp) then
            words = 'output points lie between steps'
         else if (plan%steps >= 0) then
            words = 'the number of steps is given'
         else if (.not. plan%time_step > 0.0_wp) then
            words = 'time runs backwards'
         else if (any(scene%ensemble%groups(scene%ensemble%targets%group)%name == 'integrator')) then
            words = 'a number of &integrator varies'
         end if
         if (words /= '') return
         n = count_steps(scene%initial%t, plan)
         if (n < 1 .or. n > min(plan%max_steps, most_steps)) then
            words = 'there are more than 10000000 steps'
         else if (abs(plan%end_time - real(n, wp)*plan%time_step) > same_time*plan%time_step + &
                  spacing(plan%end_time)) then
            words = 'the last step is shorter than the others'
         end if
      end associate
   end function steps_obstacle

   !> Empties all lanes.
   subroutine begin(self, scene)
      !> Prepared.
      class(lane_run_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      call self%bodies%set_up(scene%integrator%series_order, scene%plan%time_step)
   end subroutine begin

   !> Puts a member into a lane; it is not taken where lanes do not know what acts on it, or its numbers are out of
   !> their range.
   subroutine join(self, lane, member, values, columns)
      class(lane_run_t), intent(inout) :: self
      !> 1 to `lanes`.
      integer, intent(in) :: lane
      type(scene_t), intent(in) :: member
      !> The numbers in which it differs; shape (targets).
      real(wp), intent(in) :: values(:)
      !> Chosen.
      type(columns_t), intent(in) :: columns
      ! A number that was drawn can set a frame turning.
      if (abs(member%initial%t) > 0.0_wp .or. .not. can_be_lanes(member%system)) return
      call self%bodies%put(lane, member%system, member%initial)
      if (.not. self%bodies%taken(lane)) return
      associate (own => self%members(lane), j0 => member%integrator%inverse_auxiliary_inertia)
         own%system = member%system
         own%state = member%initial
         own%values = values
         own%columns = columns
         call own%columns%start(own%system, own%state, j0)
         call own%invariants%start(own%system, own%state, j0)
      end associate
   end subroutine join

   !> Runs all to their end. Errors: `NUTATE_STOPPED` where the watcher wants the end.
   subroutine run(self, sweep, status)
      class(lane_run_t), intent(inout) :: self
      !> Asked whether to go on, where there is one.
      class(sweep_watcher_t), pointer, intent(in) :: sweep
      type(status_t), intent(out) :: status
      integer(long) :: k
      integer :: i
      do k = 1, self%steps
         call self%bodies%step()
         if (.not. any(self%bodies%taken)) return
         if (mod(k, self%stride) == 0 .or. k == self%steps) then
            call self%bodies%look()
            do i = 1, lanes
               if (self%bodies%taken(i)) call measure(self%members(i), self%bodies, i)
            end do
         end if
         if (mod(k, poll_every) /= 0 .or. .not. associated(sweep)) cycle
         if (.not. sweep%wants_end()) cycle
         status = fail(NUTATE_STOPPED, 'the sweep was stopped')
         return
      end do
   end subroutine run

   !> Looks where a member is.
   subroutine measure(own, bodies, lane)
      type(lane_member_t), intent(inout) :: own
      type(taylor_lanes_t), intent(in) :: bodies
      integer, intent(in) :: lane
      call bodies%get(lane, own%state)
      call own%invariants%measure(own%system, own%state, 0.0_wp)
   end subroutine measure

   !> A lane has come to its end.
   pure logical function arrived(self, lane)
      !> Run.
      class(lane_run_t), intent(in) :: self
      integer, intent(in) :: lane
      arrived = self%bodies%taken(lane)
   end function arrived

   !> The row of a lane that has arrived.
   subroutine write_row(self, lane, number, end_time, layout, fields)
      class(lane_run_t), intent(inout) :: self
      integer, intent(in) :: lane
      !> Of the member.
      integer(long), intent(in) :: number
      !> s.
      real(wp), intent(in) :: end_time
      type(row_layout_t), intent(in) :: layout
      !> Shape (fields).
      integer(long), intent(out) :: fields(:)
      real(wp) :: columns(layout%columns - layout%values)
      type(run_record_t) :: record
      associate (own => self%members(lane))
         own%state%t = end_time
         call own%columns%evaluate(own%system, own%state, record, columns)
         fields(1) = number
         fields(2) = NUTATE_OK
         fields(3:layout%values) = bits_of(own%values)
         fields(layout%values + 1:layout%columns) = bits_of(columns)
         fields(layout%columns + 1) = bits_of(own%invariants%energy_error())
         fields(layout%columns + 2) = bits_of(own%invariants%momentum_error())
      end associate
   end subroutine write_row

end module nutate_lane_run
