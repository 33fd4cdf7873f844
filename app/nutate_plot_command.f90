!> `nutate plot`: draws a history. For the picture of a run, computes rows near enough for smooth curves.
module nutate_plot_command
   use nutate_cli, only: command_t
   use nutate_columns, only: columns_t
   use nutate_console, only: report_file, say_error, EXIT_INPUT, EXIT_OUTPUT, EXIT_SIGNAL, EXIT_SUCCESS
   use nutate_decimal, only: rounded_text
   use nutate_free_variations, only: usual_sets
   use nutate_gnuplot, only: gnuplot_is_here, is_picture, picture_t
   use nutate_hamiltonian, only: angular_velocity, system_t
   use nutate_history_plot, only: draw_history, draw_xy, name_length, read_history, read_names, recorded_t
   use nutate_kinds, only: pi, wp
   use nutate_outputs, only: outputs_t, picture_kind
   use nutate_plot_panels, only: columns_named, known_columns, set_with, usual_columns
   use nutate_printable, only: printable_path, quoted
   use nutate_quaternion, only: quat_normalized, rotate_to_space
   use nutate_run, only: run_record_t, run_t
   use nutate_run_watcher, only: caught_signal, stop_watcher_t, watch_signals
   use nutate_scene, only: scene_t
   use nutate_scene_loading, only: load_scene, propagate_free_parameters
   use nutate_spelling, only: comma_list, nearest_name, split_list
   use nutate_state, only: state_t
   use nutate_status, only: fail, status_t, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: open_picture, plot_command, draw_file, add_picture_sets, sample_rows

   !> Columns of the angular velocity in body axes.
   character(len=name_length), parameter :: rates(6) = [character(len=name_length) :: &
      'omega1', 'omega2', 'omega3', 'omega1_deg', 'omega2_deg', 'omega3_deg']
   !> Greatest value that is drawn.
   real(wp), parameter :: greatest = 1e100_wp
   !> Rotation between rows from which the title names it, rad: straight lines between the points then show.
   real(wp), parameter :: sparse = 1.0_wp

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

   !> Claims the file of a picture, if there is a gnuplot to draw it.
   subroutine open_picture(name, picture, exit_code)
      !> Name of a picture, as `is_picture` requires.
      character(len=*), intent(in) :: name
      type(picture_t), intent(inout) :: picture
      !> Exit code, changed on failure.
      integer, intent(inout) :: exit_code
      type(status_t) :: status
      if (gnuplot_is_here()) then
         call picture%open(name, status)
         call report_file(name, status, exit_code)
      else
         call say_error('nutate: cannot draw '//printable_path(name)//': gnuplot is not installed, or not on PATH')
         exit_code = EXIT_OUTPUT
      end if
   end subroutine open_picture

   !> Draws a history that was written before.
   subroutine plot_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(outputs_t) :: files
      type(picture_t) :: picture
      character(len=:), allocatable :: name

      name = without_csv(command%scene)//'.svg'
      if (allocated(command%output)) name = command%output
      exit_code = EXIT_SUCCESS
      if (.not. is_picture(name)) then
         call say_error('nutate: '//printable_path(name)// &
                        ' is not a picture file (expected the name of a file in .svg, .png or .pdf)')
         exit_code = EXIT_INPUT
         return
      end if
      call files%read_file(command%scene, 'the history itself')
      call files%add(name, picture_kind(name))
      call files%report(exit_code)
      ! A signal ends the command when the files are whole or removed.
      if (exit_code == EXIT_SUCCESS) call watch_signals()
      if (exit_code == EXIT_SUCCESS) call open_picture(name, picture, exit_code)
      if (exit_code == EXIT_SUCCESS) call draw_file(command, command%scene, name, printable_path(command%scene), &
                                                    picture, exit_code)
      if (exit_code == EXIT_SUCCESS) call note_sparse_rows(command%scene)
      if (caught_signal() /= 0) exit_code = EXIT_SIGNAL + caught_signal()
   end subroutine plot_command

   !> Finds the rotation of the body between the rows of a history that has the angular velocity.
   subroutine find_turns(file, largest, row, history, found)
      character(len=*), intent(in) :: file
      !> Largest product of rate and time between two rows, rad, and the number of the first of these.
      real(wp), intent(out) :: largest
      integer, intent(out) :: row
      !> Times and angular velocities.
      type(recorded_t), intent(out) :: history
      !> False if the history cannot be read or has no angular velocity.
      logical, intent(out) :: found
      character(len=name_length), allocatable :: names(:)
      character(len=:), allocatable :: problem
      real(wp) :: unit, turn
      integer :: i
      largest = 0.0_wp
      row = 0
      call read_names(file, names, problem)
      found = problem == ''
      if (.not. found) return
      names = pack(names, [(any(names(i) == rates), i=1, size(names))])
      found = size(names) == 3
      if (.not. found) return
      unit = merge(pi/180, 1.0_wp, index(names(1), '_deg') > 0)
      call read_history(file, names, history, problem)
      found = problem == ''
      if (.not. found) return
      history%values(:, 2:) = unit*history%values(:, 2:)
      do i = 1, size(history%values, 1) - 1
         turn = abs(history%values(i + 1, 1) - history%values(i, 1))* &
                max(norm2(history%values(i, 2:)), norm2(history%values(i + 1, 2:)))
         if (turn <= largest) cycle
         largest = turn
         row = i
      end do
   end subroutine find_turns

   !> Notes rows between which the body rotates by half a revolution or more, if the history has the angular velocity:
   !> curves through such rows show false oscillations.
   subroutine note_sparse_rows(file)
      character(len=*), intent(in) :: file
      type(recorded_t) :: history
      real(wp) :: largest, h
      integer :: row
      logical :: found
      call find_turns(file, largest, row, history, found)
      if (.not. found .or. .not. largest >= pi) return
      h = abs(history%values(row + 1, 1) - history%values(row, 1))
      call say_error('nutate: note: '//printable_path(file)//': the body turns by half a revolution or more '// &
                     'between rows, such as those after t = '//rounded_text(history%values(row, 1))//' s: curves '// &
                     'show other oscillations (expected rows less than '//rounded_text(pi*h/largest, 3)//' s apart)')
   end subroutine note_sparse_rows

   !> Returns a name without `.csv` at its end.
   pure function without_csv(name) result(stem)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: stem
      stem = name
      if (len(name) < 5) return
      if (name(len(name) - 3:) == '.csv') stem = name(:len(name) - 4)
   end function without_csv

   !> Reads a history and draws it.
   subroutine draw_file(command, file, name, title, picture, exit_code, sampled)
      !> Command with the options of the picture.
      type(command_t), intent(in) :: command
      !> Paths of the history and of the picture, and the title unless the command has one.
      character(len=*), intent(in) :: file, name, title
      !> Picture, open; complete or discarded on return.
      type(picture_t), intent(inout) :: picture
      !> Exit code, changed on failure.
      integer, intent(inout) :: exit_code
      !> Rows near each other with all their columns, to be drawn instead of those of the file.
      type(recorded_t), intent(in), optional :: sampled
      type(recorded_t) :: history
      type(status_t) :: status
      character(len=:), allocatable :: problem, shown
      logical :: is_plane
      call read_drawn()
      if (problem /= '') then
         call picture%discard()
         call say_error('nutate: '//problem, exit_code, EXIT_INPUT)
         return
      end if
      shown = title
      if (command%path /= 0) shown = title//': path of body axis '//axis_name(command%path)//', from above'
      if (allocated(command%title)) shown = printable_path(command%title)
      if (.not. present(sampled)) shown = shown//sparse_text()
      is_plane = command%path /= 0 .or. allocated(command%xy)
      if (is_plane) then
         call draw_xy(picture, shown, history, command%path /= 0, status)
      else
         call draw_history(picture, shown, history, status)
      end if
      call report_file(name, status, exit_code)

   contains

      !> Reads the columns that are drawn, in the order of the picture.
      subroutine read_drawn()
         character(len=name_length), allocatable :: names(:), wanted(:)
         problem = ''
         if (present(sampled)) then
            history = sampled
            names = sampled%names
         else
            call read_names(file, names, problem)
         end if
         if (problem == '') then
            call choose_columns(names, command, wanted, problem)
            if (problem /= '') problem = printable_path(file)//problem
         end if
         if (problem == '' .and. .not. present(sampled)) call read_history(file, wanted, history, problem)
         if (problem /= '') return
         if (size(history%values, 1) < 2) then
            problem = printable_path(file)//': no rows to plot'
            return
         end if
         call take(history, [character(len=name_length) :: 't', wanted])
         if (.not. all(abs(history%values) <= greatest)) then
            problem = printable_path(file)//': a value is too large to plot (expected up to 1e100 in size)'
         else if (.not. allocated(command%xy) .and. maxval(history%values(:, 1)) <= minval(history%values(:, 1))) then
            problem = printable_path(file)//': all rows have the same t (expected rows at different times)'
         end if
         if (problem /= '') return
         if (command%path /= 0) then
            call find_path(history, command%path)
         else if (.not. allocated(command%xy)) then
            if (.not. allocated(command%columns) .or. any(words_of(command) == 'energy')) &
               call drop_constant_energies(history)
         end if
      end subroutine read_drawn

      !> Returns a remark on rows so far apart that the curve between them shows straight lines; empty if they are near.
      function sparse_text() result(text)
         character(len=:), allocatable :: text
         type(recorded_t) :: history
         real(wp) :: largest
         integer :: row
         logical :: found
         text = ''
         call find_turns(file, largest, row, history, found)
         if (found .and. largest >= sparse) text = ' (the body rotates by up to '//rounded_text(largest, 2)// &
                                                   ' rad between rows)'
      end function sparse_text

   end subroutine draw_file

   !> Returns a body axis as the option names it.
   pure function axis_name(axis) result(name)
      integer, intent(in) :: axis
      character(len=:), allocatable :: name
      name = achar(iachar('0') + abs(axis))
      if (axis < 0) name = '−'//name
   end function axis_name

   !> Takes columns of a history, in this order.
   subroutine take(history, names)
      type(recorded_t), intent(inout) :: history
      character(len=*), intent(in) :: names(:)
      integer :: i
      history%values = history%values(:, [(findloc(history%names, names(i), dim=1), i=1, size(names))])
      history%names = names
   end subroutine take

   !> Replaces the quaternion of a history by the components x and y of a body axis along space axes.
   pure subroutine find_path(history, axis)
      !> Columns t, q0, q1, q2, q3; on return t, x, y.
      type(recorded_t), intent(inout) :: history
      !> 1, 2 or 3; negative for the opposite direction.
      integer, intent(in) :: axis
      real(wp) :: direction(3), at(3)
      integer :: i
      direction = 0.0_wp
      direction(abs(axis)) = sign(1, axis)
      do i = 1, size(history%values, 1)
         at = rotate_to_space(quat_normalized(history%values(i, 2:5)), direction)
         history%values(i, 2:3) = at(1:2)
      end do
      history%values = history%values(:, :3)
      history%names = [character(len=name_length) :: 't', 'x', 'y']
   end subroutine find_path

   !> Drops work and potential energy that are zero throughout, up to round-off in the work; without potential also the
   !> total energy, which is the kinetic one, and that if it is constant. Nothing is dropped from a history of nothing
   !> else.
   subroutine drop_constant_energies(history)
      type(recorded_t), intent(inout) :: history
      logical :: keeps(size(history%names)), is_free
      real(wp) :: values(size(history%values, 1)), scale
      integer :: i
      is_free = .true.
      keeps = .true.
      scale = 0.0_wp
      i = findloc(history%names, 'kinetic', dim=1)
      if (i > 0) scale = maxval(abs(history%values(:, i)))
      do i = 2, size(keeps)
         values = history%values(:, i)
         select case (history%names(i))
         case ('work')
            keeps(i) = maxval(abs(values)) > 1e-12_wp*scale
         case ('potential')
            is_free = maxval(abs(values)) <= 0.0_wp
            keeps(i) = .not. is_free
         case default
            continue
         end select
      end do
      if (any(history%names == 'potential') .and. is_free) then
         do i = 2, size(keeps)
            values = history%values(:, i)
            if (history%names(i) == 'total') keeps(i) = .false.
            if (history%names(i) == 'kinetic') keeps(i) = maxval(values) - minval(values) > 1e-9_wp*maxval(values)
         end do
      end if
      if (count(keeps) > 1) call take(history, pack(history%names, keeps))
   end subroutine drop_constant_energies

   !> Returns the names that the options of a picture request, of columns or sets; shape (number of names).
   pure function words_of(command) result(words)
      type(command_t), intent(in) :: command
      character(len=name_length), allocatable :: words(:)
      allocate (words(0))
      if (allocated(command%columns)) words = adjustl([character(len=name_length) :: split_list(command%columns)])
      if (allocated(command%xy)) words = [character(len=name_length) :: command%xy(:index(command%xy, ':') - 1), &
                                          command%xy(index(command%xy, ':') + 1:)]
      if (command%path /= 0) words = [character(len=name_length) :: 'q0', 'q1', 'q2', 'q3']
   end function words_of

   !> Chooses the columns that are drawn, in the order of the history, or x before y.
   pure subroutine choose_columns(names, command, wanted, problem)
      !> Names of all columns of the history, `t` first.
      character(len=*), intent(in) :: names(:)
      type(command_t), intent(in) :: command
      character(len=name_length), allocatable, intent(out) :: wanted(:)
      !> Error message, to be written after the name of the file; empty on success.
      character(len=:), allocatable, intent(inout) :: problem
      character(len=name_length), allocatable :: words(:)
      logical :: chosen(size(names)), found(size(names))
      integer :: i
      words = words_of(command)
      chosen = .false.
      allocate (wanted(0))
      if (size(words) == 0) then
         chosen = usual_columns(names, command%residuals)
         if (.not. any(chosen)) chosen = known_columns(names)
         if (.not. any(chosen)) problem = ': none of its columns is a column of nutate (expected --columns NAME,...)'
      end if
      do i = 1, size(words)
         found = columns_named(trim(words(i)), names)
         if (.not. any(found)) then
            problem = ': there is no column '//quoted(trim(words(i)))// &
                      ' (expected '//printable_path(comma_list(names(2:)))//hint(words(i), names)//')'
         else if (allocated(command%xy) .and. count(found) > 1) then
            problem = ': '//quoted(trim(words(i)))//' is a set of columns (expected one column'//': '// &
                      trim(names(findloc(found, .true., dim=1)))//', ...)'
         end if
         if (problem /= '') return
         ! A set shows its residuals only if it has nothing else.
         if (count(found) > 1 .and. any(found .and. usual_columns(names, .false.))) &
            found = found .and. (usual_columns(names, .false.) .or. .not. usual_columns(names, .true.))
         chosen = chosen .or. found
         if (allocated(command%xy)) wanted = [wanted, pack(names, found)]
      end do
      if (command%residuals .and. size(words) > 0) chosen = chosen .or. (usual_columns(names, .true.) .and. &
                                                                         .not. usual_columns(names, .false.))
      if (.not. allocated(command%xy)) wanted = pack(names, chosen)
   end subroutine choose_columns

   !> Returns the known name that a word probably means, as the end of a message; blank if none is near.
   pure function hint(word, names) result(text)
      character(len=*), intent(in) :: word, names(:)
      character(len=:), allocatable :: text
      text = nearest_name(trim(word), names)
      if (text /= '') text = '; nearest: '//trim(text)
   end function hint

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
            status = fail(NUTATE_BAD_ARGUMENT, 'there is no column '//quoted(trim(words(i)))// &
                          ' (expected a column or a set of columns'//hint(words(i), names)//')')
            return
         end if
         if (.not. any(sets == set)) sets = [sets, set]
      end do
      call columns%choose(sets, status, scene%output%degrees, scene%system%effects, scene%propagated())
   end subroutine add_picture_sets

   !> Repeats a run for its picture, if its rows are too far apart for smooth curves or lack a column.
   subroutine sample_rows(command, first, sampled)
      type(command_t), intent(in) :: command
      !> Scene of the run, after it.
      type(scene_t), intent(in) :: first
      !> Rows of the repeated run; not allocated if those of the history are drawn.
      type(recorded_t), allocatable, intent(out) :: sampled
      type(scene_t) :: scene
      type(status_t) :: status
      character(len=name_length), allocatable :: sets(:)
      real(wp) :: t(2), needed
      logical :: lacks
      integer :: exit_code, i, rows
      if (allocated(command%resume)) return
      call load_scene(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      scene%output%columns = usual_sets(scene)
      call add_picture_sets(command, scene, sets, status)
      if (.not. status%ok()) return
      lacks = size(sets) > size(scene%output%columns)
      call find_need(first%output%file)
      if (.not. lacks .and. (needed <= 0.0_wp .or. needed > most_rows)) return
      rows = int(min(max(needed, real(least_rows, wp)), real(most_rows, wp)))
      scene%plan%times = [(t(1) + (t(2) - t(1))*(real(i, wp)/rows), i=0, rows - 1), t(2)]
      scene%output%columns = sets
      call run_again(rows + 1)

   contains

      !> Finds the times of a history, and how many rows its motion needs: 0 if its own are near enough.
      subroutine find_need(file)
         character(len=*), intent(in) :: file
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
      subroutine run_again(rows)
         !> Greatest number of rows.
         integer, intent(in) :: rows
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
         if (.not. status%ok() .or. exit_code /= EXIT_SUCCESS) return
         allocate (keeper%values(keeper%columns%width, rows))
         keeper%rows = 0
         keeper%observes_every_step = keeper%columns%follows_steps
         keeper%wants_works = keeper%columns%needs_works
         keeper%wants_tangent = keeper%columns%differentiates
         call keeper%columns%start(scene%system, scene%initial, scene%integrator%inverse_auxiliary_inertia, &
                                   scene%plan%end_time < scene%initial%t)
         call run%run_to_end(scene%system, status, keeper)
         if (.not. status%ok() .or. keeper%rows < 2) return
         allocate (sampled)
         sampled%names = [character(len=name_length) :: split_list(keeper%columns%header())]
         sampled%values = transpose(keeper%values(:, :keeper%rows))
      end subroutine run_again

   end subroutine sample_rows

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

end module nutate_plot_command
