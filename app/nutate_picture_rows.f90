!> Rows for the picture of a run, near enough to each other for smooth curves: a second run evaluates its dense output.
module nutate_picture_rows
   use nutate_cli, only: command_t
   use nutate_columns, only: columns_t
   use nutate_console, only: EXIT_SUCCESS
   use nutate_free_variations, only: usual_sets
   use nutate_hamiltonian, only: angular_velocity
   use nutate_history_plot, only: name_length, read_history, recorded_t
   use nutate_kinds, only: wp
   use nutate_observer, only: run_record_t
   use nutate_plot_command, only: find_turns, words_of
   use nutate_plot_panels, only: columns_named, set_with
   use nutate_printable, only: quoted
   use nutate_run, only: run_t
   use nutate_run_watcher, only: stop_watcher_t
   use nutate_scene, only: scene_t
   use nutate_scene_loading, only: load_scene, propagate_free_parameters
   use nutate_spelling, only: nearest_name, split_list
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   implicit none
   private

   public :: add_picture_sets, sample_rows

   !> Rotation between rows above which they are replaced, and between the new rows, rad.
   real(wp), parameter :: too_far = 0.15_wp, near = 0.1_wp
   !> Least and greatest number of new rows. A motion that needs more is drawn by its own rows.
   integer, parameter :: least_rows = 400, most_rows = 20000

   !> Observer that keeps the rows.
   type, extends(stop_watcher_t) :: row_keeper_t
      type(columns_t) :: columns
      !> Values; shape (columns, rows).
      real(wp), allocatable :: values(:, :)
      integer :: rows = 0
   contains
      procedure :: observe => keep_row
      procedure :: observe_step => follow_state
   end type row_keeper_t

contains

   !> Adds the sets that the options of a picture request to those of a scene. Errors: `NUTATE_BAD_ARGUMENT` for an
   !> unknown name and for a set that the scene cannot have.
   subroutine add_picture_sets(command, scene, sets, status)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      !> Names of the sets.
      character(len=name_length), allocatable, intent(out) :: sets(:)
      type(status_t), intent(out) :: status
      type(columns_t) :: columns
      character(len=name_length), allocatable :: words(:), names(:)
      character(len=name_length) :: set
      character(len=:), allocatable :: nearest
      integer :: i
      sets = [character(len=name_length) :: scene%output%columns]
      words = words_of(command)
      call columns%choose(scene%output%columns, status, scene%output%degrees, scene%system%effects, scene%propagated())
      if (.not. status%ok() .or. size(words) == 0) return
      names = [character(len=name_length) :: split_list(columns%header())]
      do i = 1, size(words)
         if (any(columns_named(trim(words(i)), names))) cycle
         set = set_with(trim(words(i)), scene%system%effects)
         if (set == '') then
            nearest = nearest_name(trim(words(i)), names)
            if (nearest /= '') nearest = '; nearest: '//trim(nearest)
            status = fail(NUTATE_BAD_ARGUMENT, 'there is no column '//quoted(trim(words(i)))// &
                          ' (expected a column or a set of columns'//nearest//')')
            return
         end if
         if (.not. any(sets == set)) sets = [sets, set]
      end do
      call columns%choose(sets, status, scene%output%degrees, scene%system%effects, scene%propagated())
   end subroutine add_picture_sets

   !> Repeats a run for its picture, if its rows are too far apart for smooth curves or lack a column.
   subroutine sample_rows(command, first, sampled, found)
      type(command_t), intent(in) :: command
      !> Scene of the run, after it.
      type(scene_t), intent(in) :: first
      type(recorded_t), intent(out) :: sampled
      !> False if the rows of the history are drawn.
      logical, intent(out) :: found
      type(scene_t) :: scene
      type(status_t) :: status
      character(len=name_length), allocatable :: sets(:)
      real(wp) :: t(2), needed
      logical :: lacks
      integer :: exit_code, i, rows
      found = .false.
      if (allocated(command%resume)) return
      call load_scene(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      scene%output%columns = usual_sets(scene)
      call add_picture_sets(command, scene, sets, status)
      if (.not. status%ok()) return
      lacks = size(sets) > size(scene%output%columns)
      call find_need(first%output%file, scene, t, needed)
      if (.not. lacks .and. (needed <= 0.0_wp .or. needed > most_rows)) return
      rows = int(min(max(needed, real(least_rows, wp)), real(most_rows, wp)))
      scene%plan%times = [(t(1) + (t(2) - t(1))*(real(i, wp)/rows), i=0, rows - 1), t(2)]
      scene%output%columns = sets
      call run_again(scene, rows + 1, sampled, found)
   end subroutine sample_rows

   !> Finds the times of a history, and how many rows its motion needs: 0 if its own are near enough.
   subroutine find_need(file, scene, t, needed)
      character(len=*), intent(in) :: file
      !> Scene before the run.
      type(scene_t), intent(in) :: scene
      !> First and last time, s.
      real(wp), intent(out) :: t(2), needed
      type(recorded_t) :: history
      character(len=:), allocatable :: problem
      real(wp) :: largest, fastest
      integer :: i, row, rows
      logical :: found
      call find_turns(file, largest, row, history, found)
      fastest = norm2(angular_velocity(scene%system, scene%initial))
      if (found) fastest = max(fastest, maxval([(norm2(history%values(i, 2:)), i=1, size(history%values, 1))]))
      if (.not. found) call read_history(file, [character(len=name_length) ::], history, problem)
      t = scene%initial%t
      needed = 0.0_wp
      rows = size(history%values, 1)
      if (rows < 2) return
      t = [history%values(1, 1), history%values(rows, 1)]
      if (.not. found) largest = fastest*abs(t(2) - t(1))/(rows - 1)
      if (largest > too_far) needed = fastest*abs(t(2) - t(1))/near
   end subroutine find_need

   !> Runs a scene and keeps its rows.
   subroutine run_again(scene, rows, sampled, found)
      type(scene_t), intent(inout) :: scene
      !> Greatest number of rows.
      integer, intent(in) :: rows
      type(recorded_t), intent(out) :: sampled
      !> False if the run failed.
      logical, intent(out) :: found
      type(run_t) :: run
      type(row_keeper_t) :: keeper
      type(status_t) :: status
      integer :: exit_code
      exit_code = EXIT_SUCCESS
      call run%begin(scene%system, scene%integrator, scene%initial, scene%plan, status)
      if (status%ok()) call run%set_events(scene%events, scene%system, status)
      if (status%ok()) call propagate_free_parameters(scene, run, exit_code)
      if (status%ok()) call run%follow_chaos(scene%chaos, scene%system, status)
      if (status%ok()) call run%find_steps(scene%system, status, keeper)
      if (status%ok()) call keeper%columns%choose(scene%output%columns, status, scene%output%degrees, &
                                                  scene%system%effects, scene%propagated())
      found = status%ok() .and. exit_code == EXIT_SUCCESS
      if (.not. found) return
      allocate (keeper%values(keeper%columns%width, rows))
      keeper%rows = 0
      keeper%observes_every_step = keeper%columns%follows_steps
      keeper%wants_works = keeper%columns%needs_works
      keeper%wants_tangent = keeper%columns%differentiates
      call keeper%columns%start(scene%system, scene%initial, scene%integrator%inverse_auxiliary_inertia, &
                                scene%plan%end_time < scene%initial%t)
      call run%run_to_end(scene%system, status, keeper)
      found = status%ok() .and. keeper%rows > 1
      sampled%names = [character(len=name_length) :: split_list(keeper%columns%header())]
      sampled%values = transpose(keeper%values(:, :keeper%rows))
   end subroutine run_again

   !> Keeps a row; those of trial runs are passed over.
   subroutine keep_row(self, system, state, record, status)
      class(row_keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (.not. allocated(self%values)) return
      if (self%rows == size(self%values, 2)) return
      self%rows = self%rows + 1
      call self%columns%evaluate(system, state, record, self%values(:, self%rows), self%tangent, self%chaos)
      call self%columns%check_row(self%values(:, self%rows), status)
   end subroutine keep_row

   !> Follows angles from step to step.
   subroutine follow_state(self, state)
      class(row_keeper_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      call self%columns%follow(state)
   end subroutine follow_state

end module nutate_picture_rows
