!> The help pages, made from the tables of commands, options and columns.
module nutate_help
   use nutate_cli, only: options, verbs
   use nutate_console, only: page_t
   use nutate_quantities, only: set_headers, set_names
   use nutate_spelling, only: is_listed
   implicit none
   private

   public :: help_page

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
      do i = 1, size(verbs)
         if (verbs(i)%name == topic) call page%line('nutate '//trim(topic)//': '//trim(verbs(i)%purpose))
      end do
      call page%line('')
      i = findloc(verbs%name == topic, .true., dim=1)
      call page%line('Usage: nutate '//trim(topic)//' '//trim(verbs(i)%object)//' [options]')
      call page%line('')
      call page%line('Options')
      do i = 1, size(options)
         if (is_listed(topic, trim(options(i)%verbs))) call page%item( &
            trim(options(i)%name)//' '//options(i)%value, options(i)%purpose)
      end do
      if (topic == 'run') call add_run_notes(page)
      if (topic == 'cost') call add_cost_notes(page)
      if (topic == 'plot') call add_plot_notes(page)
      if (topic == 'export') call add_export_notes(page)
      if (topic == 'sweep') call add_sweep_notes(page)
      if (topic == 'fit') call add_fit_notes(page)
      if (topic == 'linearize') call add_linearize_notes(page)
      if (topic == 'view') call add_view_notes(page)
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

   !> Adds notes on the history and its columns.
   subroutine add_run_notes(page)
      type(page_t), intent(inout) :: page
      integer :: i
      call page%line('')
      call page%line('The history is one CSV file, named by the scene unless --output is given. It is written')
      call page%line('as FILE.partial and renamed when complete; a run that fails leaves its rows in FILE.partial.')
      call page%line('SIGINT, SIGTERM and SIGHUP do the same and then terminate the process.')
      call page%line('')
      call page%line('The checkpoint is written at the start, every N seconds and when the run is interrupted, and')
      call page%line('removed when the run is complete. --resume continues to the same bytes, with checkpoints in the')
      call page%line('same file unless --checkpoint names another. Scene and overrides must be the same.')
      call page%line('')
      call page%line('With &chaos the summary has Lyapunov exponents, MEGNO and FLI; --set chaos.exponents=6')
      call page%line('computes all six exponents.')
      call page%line('')
      call page%line("Columns: t, then the sets selected with --set output.columns=NAME,NAME,...")
      associate (sets => set_names())
         do i = 1, size(sets)
            call add_columns(page, sets(i), set_headers(sets(i)))
         end do
      end associate
      call add_exit_codes(page)
   end subroutine add_run_notes

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

   !> Adds notes on work-precision studies.
   subroutine add_cost_notes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('The scene is run with every method at a series of time steps, each half of the one before,')
      call page%line('from about 4 rad of rotation per step down to round-off, as far as the time allows; taylor,')
      call page%line('which has adaptive steps, at a series of tolerances, each a tenth of the one before. Times are')
      call page%line('medians of repeated runs without output; errors come from a separate run. The attitude')
      call page%line('error is that at end_time, from the exact motion (free bodies, tops on their axis of symmetry)')
      call page%line('or from two independent methods that agree. A table of the runs goes to standard output,')
      call page%line('followed by one of run time for given accuracies, fastest first. --plot draws six methods,')
      call page%line('--all all of them.')
      call add_exit_codes(page)
   end subroutine add_cost_notes

   !> Adds notes on plots.
   subroutine add_plot_notes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('Draws a panel for each quantity in the history, with its unit: all columns of nutate, or')
      call page%line('those selected with --columns by column name (omega3) or set name (energy).')
      call page%line('The ending of the picture is .svg, .png or .pdf.')
      call add_exit_codes(page)
   end subroutine add_plot_notes

   !> Adds notes on exports and the data that they need.
   subroutine add_export_notes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('The history needs the columns q0 to q3; omega1 to omega3 give the angular velocities. Epoch of')
      call page%line('t = 0, time system, names of body and axes, and the body come from --scene SCENE, or from')
      call page%line('--set scene.epoch=DATE, scene.time_system=TDB|TT|TAI|UTC, scene.object=NAME,')
      call page%line('scene.space_frame=NAME, scene.body_frame=NAME, body.inertia=J1,J2,J3. The quaternion of an')
      call page%line('AEM is (q1, q2, q3, q0): from the space axes, REF_FRAME_A, to the body axes, REF_FRAME_B,')
      call page%line('scalar last. - is standard output.')
      call add_exit_codes(page)
   end subroutine add_export_notes

   !> Adds notes on sweeps.
   subroutine add_sweep_notes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('The members of &ensemble differ in the values that &vary groups draw or a table lists. Their')
      call page%line('result rows go to the NumPy file FILE.npy, which FILE.npy.txt describes. It is written as')
      call page%line('FILE.npy.partial, chunk by chunk; --resume continues after SIGINT, SIGKILL or a power failure')
      call page%line('to the same bytes, which depend on scene, seed and member only, not on threads or chunks.')
      call page%line('--members A:B writes FILE.A-B.npy; --merge merges such files. --member K repeats one member')
      call page%line('with its history in FILE.memberK.csv. With &chaos rows have the Lyapunov exponents, MEGNO and')
      call page%line('FLI of the members: a map of chaos where two keys vary on a grid.')
      call add_exit_codes(page)
   end subroutine add_sweep_notes

   !> Adds notes on fits.
   subroutine add_fit_notes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('The numbers that &free names are changed until the motion agrees with the CSV files that')
      call page%line('&measurement names. They are printed with standard errors, chi-squared, correlations above')
      call page%line('0.95, and what the data do not determine, by name. If --max-steps ends the fit, the files')
      call page%line('hold the best one so far.')
      call add_exit_codes(page)
   end subroutine add_fit_notes

   !> Adds notes on linearisations.
   subroutine add_linearize_notes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('Prints A and B of dx/dt = A x + B u at the equilibrium that the scene starts from, and the')
      call page%line('eigenvalues of A. x holds a rotation vector of the body from the motion, and the changes of')
      call page%line('angular velocity, body axes, and of the speeds of the wheels; u torques about the body axes and')
      call page%line('of the motors. A start that is no equilibrium is rejected, with its angular acceleration.')
      call page%line('The angular velocity is absolute; with --relative-rates it is relative to axes that rotate with')
      call page%line('the equilibrium, such as those of an orbit.')
      call page%line('With --period, x(T) = A x(0) + B u after a period, with inputs that are constant in it; the')
      call page%line('eigenvalues of A are then the Floquet multipliers.')
      call page%line('')
      call page%line('With --equilibria, all attitudes in which a body with rotors and wheels rests in the space axes,')
      call page%line('or on a circular orbit in the LVLH frame. The index counts the negative directions of the')
      call page%line('effective potential, growth is the largest real part of an eigenvalue.')
      call add_exit_codes(page)
   end subroutine add_linearize_notes

   !> Adds notes on the page of a view and its requirements.
   subroutine add_view_notes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('The page shows the body (its shape, or the box of its inertia), the path of its symmetry')
      call page%line('axis or of its centre of mass, angular velocity and momentum, reaction wheels, the LVLH frame,')
      call page%line('the polhode on the inertia ellipsoid, and curves with events and a moving cursor. The body')
      call page%line('turns by less than 0.3 rad from frame to frame, however few rows the scene writes. The page')
      call page%line('needs no network. python3 writes it, with the Python package of nutate; in a notebook')
      call page%line('nutate.view(result) shows it.')
      call add_exit_codes(page)
   end subroutine add_view_notes

   subroutine add_exit_codes(page)
      type(page_t), intent(inout) :: page
      call page%line('')
      call page%line('Exit status: 0 success; 2 error in the command line or the scene; 3 the run failed;')
      call page%line('4 the output could not be written')
   end subroutine add_exit_codes

end module nutate_help
