!> The help pages, made from the tables of commands, options and columns.
module nutate_help
   use nutate_cli, only: options, verbs
   use nutate_console, only: page_t
   use nutate_quantities, only: set_headers, set_names
   use nutate_spelling, only: is_listed
   implicit none
   private

   public :: help_page

   !> Longest line of a note.
   integer, parameter :: note_length = 96
   !> Notes on the commands, below their options.
   character(len=*), parameter :: run_notes(*) = [character(len=note_length) :: &
      'The history is one CSV file, named by the scene unless --output is given. It is written', &
      'as FILE.partial and renamed when complete; a run that fails leaves its rows in FILE.partial.', &
      'SIGINT, SIGTERM and SIGHUP do the same and then terminate the process.', &
      '', &
      'The checkpoint is written at the start, every N seconds and when the run is interrupted, and', &
      'removed when the run is complete. --resume continues to the same bytes, with checkpoints in the', &
      'same file unless --checkpoint names another. Scene and overrides must be the same.', &
      '', &
      'With &chaos the summary has Lyapunov exponents, MEGNO and FLI; --set chaos.exponents=6', &
      'computes all six exponents.', &
      '']
   character(len=*), parameter :: cost_notes(*) = [character(len=note_length) :: &
      'The scene is run with every method at a series of time steps, each half of the one before,', &
      'from about 4 rad of rotation per step down to round-off, as far as the time allows; taylor,', &
      'which has adaptive steps, at a series of tolerances, each a tenth of the one before. Times are', &
      'medians of repeated runs without output; errors come from a separate run. The attitude', &
      'error is that at end_time, from the exact motion (free bodies, tops on their axis of symmetry)', &
      'or from two independent methods that agree. A table of the runs goes to standard output,', &
      'followed by one of run time for given accuracies, fastest first. --plot draws six methods,', &
      '--all all of them.']
   character(len=*), parameter :: plot_notes(*) = [character(len=note_length) :: &
      'Draws a panel for each quantity in the history, with its unit: all columns of nutate, or', &
      'those selected with --columns by column name (omega3) or set name (energy).', &
      'The ending of the picture is .svg, .png or .pdf.']
   character(len=*), parameter :: export_notes(*) = [character(len=note_length) :: &
      'The history needs the columns q0 to q3; omega1 to omega3 give the angular velocities. Epoch of', &
      't = 0, time system, names of body and axes, and the body come from --scene SCENE, or from', &
      '--set scene.epoch=DATE, scene.time_system=TDB|TT|TAI|UTC, scene.object=NAME,', &
      'scene.space_frame=NAME, scene.body_frame=NAME, body.inertia=J1,J2,J3. The quaternion of an', &
      'AEM is (q1, q2, q3, q0): from the space axes, REF_FRAME_A, to the body axes, REF_FRAME_B,', &
      'scalar last. - is standard output.']
   character(len=*), parameter :: sweep_notes(*) = [character(len=note_length) :: &
      'The members of &ensemble differ in the values that &vary groups draw or a table lists. Their', &
      'result rows go to the NumPy file FILE.npy, which FILE.npy.txt describes. It is written as', &
      'FILE.npy.partial, chunk by chunk; --resume continues after SIGINT, SIGKILL or a power failure', &
      'to the same bytes, which depend on scene, seed and member only, not on threads or chunks.', &
      '--members A:B writes FILE.A-B.npy; --merge merges such files. --member K repeats one member', &
      'with its history in FILE.memberK.csv. With &chaos rows have the Lyapunov exponents, MEGNO and', &
      'FLI of the members: a map of chaos if two keys vary on a grid.']
   character(len=*), parameter :: fit_notes(*) = [character(len=note_length) :: &
      'Determines the parameters in &free for which the motion agrees with the data files in', &
      '&measurement. Prints them with standard errors, chi-squared, correlations above 0.95, and the', &
      'parameters that the data do not determine. If --max-steps ends the fit, the files hold the', &
      'best one so far.']
   character(len=*), parameter :: linearize_notes(*) = [character(len=note_length) :: &
      'Prints A and B of dx/dt = A x + B u at the equilibrium that the scene starts from, and the', &
      'eigenvalues of A. x holds a rotation vector of the body from the motion, and the changes of', &
      'angular velocity, body axes, and of the speeds of the wheels; u torques about the body axes and', &
      'of the motors. An initial state that is not an equilibrium is rejected, with its angular', &
      'acceleration. The angular velocity is absolute; with --relative-rates it is relative to axes', &
      'that rotate with the equilibrium, such as the LVLH frame.', &
      'With --period, x(T) = A x(0) + B u after a period, with inputs that are constant in it; the', &
      'eigenvalues of A are then the Floquet multipliers.', &
      '', &
      'With --equilibria, prints all attitudes in which a body with rotors and wheels rests in the', &
      'space axes, or on a circular orbit in the LVLH frame. The index is the number of directions in', &
      'which the effective potential falls, growth is the largest real part of an eigenvalue.']
   character(len=*), parameter :: view_notes(*) = [character(len=note_length) :: &
      'The page shows the body (its shape, or one with its moments), the path of its symmetry', &
      'axis or of its centre of mass, angular velocity and momentum, reaction wheels, the LVLH frame,', &
      'the polhode on the inertia ellipsoid, and curves with events and a moving cursor. The body', &
      'rotates by less than 0.3 rad from frame to frame, however few rows the scene writes. The page', &
      'needs no network. python3 writes it, with the Python package of nutate; in a notebook', &
      'nutate.view(result) shows it.']

contains

   !> Returns the help on a command, or on the program.
   function help_page(topic) result(page)
      !> Name of a command; blank for the program.
      character(len=*), intent(in) :: topic
      type(page_t) :: page
      integer :: i
      if (topic == '') then
         call add_overview(page)
         return
      end if
      i = findloc(verbs%name == topic, .true., dim=1)
      call page%line('nutate '//trim(topic)//': '//trim(verbs(i)%purpose))
      call page%line('')
      call page%line('Usage: nutate '//trim(topic)//' '//trim(verbs(i)%object)//' [options]')
      call page%line('')
      call page%line('Options')
      do i = 1, size(options)
         if (is_listed(topic, trim(options(i)%verbs))) call page%item( &
            trim(options(i)%name)//' '//options(i)%value, options(i)%purpose)
      end do
      if (topic == 'run') call add_notes(page, run_notes)
      if (topic == 'cost') call add_notes(page, cost_notes)
      if (topic == 'plot') call add_notes(page, plot_notes)
      if (topic == 'export') call add_notes(page, export_notes)
      if (topic == 'sweep') call add_notes(page, sweep_notes)
      if (topic == 'fit') call add_notes(page, fit_notes)
      if (topic == 'linearize') call add_notes(page, linearize_notes)
      if (topic == 'view') call add_notes(page, view_notes)
      if (topic == 'run') call add_sets(page)
      if (topic /= 'check') call add_exit_codes(page)
   end function help_page

   subroutine add_overview(page)
      type(page_t), intent(inout) :: page
      integer :: i
      call page%line('nutate: rotational dynamics of rigid bodies; energy and momentum conserved to round-off')
      call page%line('')
      call page%line('Usage')
      do i = 1, size(verbs)
         call page%item('nutate '//trim(verbs(i)%name)//' '//trim(verbs(i)%object), verbs(i)%purpose)
      end do
      call page%item('nutate SCENE', 'short for nutate run SCENE')
      call page%item('nutate help COMMAND', 'options of a command; nutate COMMAND --help does the same')
      call page%item('nutate --help', 'show this help')
      call page%item('nutate --version', 'show the version')
      call add_exit_codes(page)
   end subroutine add_overview

   !> Adds the columns of a history, set by set.
   subroutine add_sets(page)
      type(page_t), intent(inout) :: page
      integer :: i
      call page%line("Columns: t, then the sets selected with --set output.columns=NAME,NAME,...")
      associate (sets => set_names())
         do i = 1, size(sets)
            call add_columns(page, sets(i), set_headers(sets(i)))
         end do
      end associate
   end subroutine add_sets

   !> Adds notes on a command, after a blank line.
   subroutine add_notes(page, notes)
      type(page_t), intent(inout) :: page
      character(len=*), intent(in) :: notes(:)
      integer :: i
      call page%line('')
      do i = 1, size(notes)
         call page%line(trim(notes(i)))
      end do
   end subroutine add_notes

   !> Adds a set with its columns, on as many lines as it needs.
   subroutine add_columns(page, name, headers)
      type(page_t), intent(inout) :: page
      character(len=*), intent(in) :: name, headers
      integer, parameter :: widest = 80
      integer :: first, last
      first = 1
      do while (first <= len(headers))
         last = len(headers)
         if (last - first >= widest) last = first - 1 + index(headers(first:first + widest - 1), ',', back=.true.)
         if (first == 1) call page%item(name, headers(:last))
         if (first > 1) call page%item('', headers(first:last))
         first = last + 1
      end do
   end subroutine add_columns

   subroutine add_exit_codes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('Exit status: 0 success; 2 error in the command line or the scene; 3 the run failed;')
      call page%line('4 the output could not be written')
   end subroutine add_exit_codes

end module nutate_help
