!> `nutate linearize`: reads a scene, and writes matrices, eigenvalues and periodic motions.
module nutate_linearize_command
   use nutate_scene_loading, only: add_space_axes, load_scene
   use nutate_cli, only: command_t
   use nutate_console, only: count_text, page_t, plural, say_error, show_page, vector_text, EXIT_INPUT, EXIT_RUN, &
      EXIT_SUCCESS
   use nutate_decimal, only: rounded_text
   use nutate_outputs, only: outputs_t, write_whole, LINEARIZATION
   use nutate_equilibria, only: equilibria_t
   use nutate_files, only: STANDARD_ERROR, STANDARD_OUTPUT
   use nutate_kinds, only: long, pi, wp
   use nutate_linearization, only: linearization_t
   use nutate_linearization_json, only: json_of, json_of_equilibria
   use nutate_periodic_start, only: on_circle, periodic_start_t
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t
   use nutate_scene_linearization, only: linearize_scene, scene_equilibria
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   use nutate_table, only: number_text, table_t
   implicit none
   private

   public :: add_periodic, add_equilibria, add_linearization, linearize_command

   !> Digits of matrices and eigenvalues; sizes, relative to the largest of a row and of the eigenvalues, up to which a
   !> number is printed as 0. Rounding splits a double eigenvalue by its square root.
   integer, parameter :: digits = 7
   real(wp), parameter :: negligible = 1e-12_wp, indistinct = 1e-7_wp

contains

   !> Adds the result of Newton's method: the free librations by the multipliers, stability, condition, families.
   subroutine add_periodic(page, start)
      type(page_t), intent(inout) :: page
      !> Periodic initial state; nothing is added if it has no revolutions.
      type(periodic_start_t), intent(in) :: start
      if (start%revolutions == 0) return
      call page%item('periodic motion', 'periodic to '//rounded_text(start%defect, 2)// &
                     ' (rad, and rad/s over n); found after '//plural(int(start%revolutions, long), 'revolution'))
      associate (frequencies => start%free_frequencies())
         if (size(frequencies) > 0) call page%item('  free librations', 'frequencies (k ± f) n for integer k, f = '// &
                                                  vector_text(frequencies))
      end associate
      call page%item('  multipliers', multipliers_text(start))
      call page%item('  condition', rounded_text(start%condition, 2)//', of M - I, M the monodromy matrix')
      if (start%n_families > 0) call page%item('  family', 'one of many periodic motions: M - I is '// &
         'singular in '//plural(int(start%n_families, long), 'direction')//', which the smallest correction left alone')
   end subroutine add_periodic

   !> Returns in words the stability that the multipliers imply.
   function multipliers_text(start) result(text)
      type(periodic_start_t), intent(in) :: start
      character(len=:), allocatable :: text
      if (start%growth() > 1 + on_circle) then
         text = 'unstable: deviations grow by '//rounded_text(start%growth())//' in a revolution'
      else
         text = 'all of modulus 1: stable to first order'
      end if
   end function multipliers_text

   !> Adds the motion, the matrices and the eigenvalues.
   subroutine add_linearization(page, linear)
      type(page_t), intent(inout) :: page
      type(linearization_t), intent(in) :: linear
      if (linear%period > 0.0_wp) then
         call page%item('motion', 'a period of '//number_text(linear%period, 10)//' s')
         if (linear%closes) then
            call page%item('closure', 'to '//number_text(linear%residual, 2)//' rad/s')
         else
            call page%item('closure', 'none: the motion does not return to its start (velocities to '// &
                           number_text(linear%residual, 2)//' rad/s)')
         end if
      else
         call page%item('motion', 'equilibrium')
         call page%item('residual', number_text(linear%residual, 2)//' rad/s^2')
      end if
      call page%item('attitude', 'quaternion '//vector_text(linear%q, 9))
      call page%item('angular velocity', vector_text(linear%omega, 9)//' rad/s')
      if (linear%absolute) then
         call page%item('rates of states', 'absolute, relative to the stars')
      else
         call page%item('rates of states', 'relative to axes that rotate with the equilibrium')
      end if
      if (size(linear%speeds) > 0) call page%item('wheel speeds', vector_text(linear%speeds, 9)//' rad/s')
      call page%line('')
      if (linear%period > 0.0_wp) then
         call add_matrix(page, 'A, after a period, with respect to the initial state', linear%a, linear%states, linear)
         call add_matrix(page, 'B, after a period, with respect to constant inputs', linear%b, linear%inputs, linear)
      else
         call add_matrix(page, 'A, rates by states', linear%a, linear%states, linear)
         call add_matrix(page, 'B, rates by inputs', linear%b, linear%inputs, linear)
      end if
      call add_eigenvalues(page, linear)
   end subroutine add_linearization

   !> Adds a matrix with the names of its rows and columns.
   subroutine add_matrix(page, title, matrix, names, linear)
      type(page_t), intent(inout) :: page
      character(len=*), intent(in) :: title
      real(wp), intent(in) :: matrix(:, :)
      !> Names of the columns.
      character(len=*), intent(in) :: names(:)
      type(linearization_t), intent(in) :: linear
      type(table_t) :: table
      integer :: i, k
      table%indent = 2
      call table%add_column('')
      do k = 1, size(names)
         call table%add_column(trim(names(k)), digits=digits)
      end do
      do i = 1, size(matrix, 1)
         call table%add_row()
         call table%put(linear%states(i))
         do k = 1, size(names)
            call table%put(without_rounding(matrix(i, k), negligible*maxval(abs(matrix(i, :)))))
         end do
      end do
      call page%line(title)
      call page%line(table%text())
      call page%line('')
   end subroutine add_matrix

   !> Adds the eigenvalues; of a conjugate pair, only one.
   subroutine add_eigenvalues(page, linear)
      type(page_t), intent(inout) :: page
      type(linearization_t), intent(in) :: linear
      type(table_t) :: table
      real(wp) :: re, im, least
      integer :: i
      table%indent = 2
      call table%add_column('real', digits=digits)
      call table%add_column('imaginary', digits=digits)
      call table%add_column(merge('modulus   ', 'period (s)', linear%period > 0.0_wp), digits=digits)
      least = indistinct*maxval(abs(linear%eigenvalues))
      do i = 1, size(linear%eigenvalues)
         re = without_rounding(real(linear%eigenvalues(i), wp), least)
         im = without_rounding(aimag(linear%eigenvalues(i)), least)
         if (im < 0.0_wp) cycle
         call table%add_row()
         call table%put(re)
         if (im > 0.0_wp) then
            call table%put(im, '±')
         else
            call table%put(im)
         end if
         if (linear%period > 0.0_wp) then
            call table%put(abs(linear%eigenvalues(i)))
         else if (im > 0.0_wp) then
            call table%put(2*pi/im)
         end if
      end do
      if (.not. linear%period > 0.0_wp) then
         call page%line('Eigenvalues of A (1/s)')
      else if (linear%closes) then
         call page%line('Floquet multipliers')
      else
         call page%line('Eigenvalues of A')
      end if
      call page%line(table%text())
   end subroutine add_eigenvalues

   !> Adds all equilibria of a body, by energy.
   subroutine add_equilibria(page, found)
      type(page_t), intent(inout) :: page
      type(equilibria_t), intent(in) :: found
      character(len=2), parameter :: components(4) = ['q0', 'q1', 'q2', 'q3']
      type(table_t) :: table
      character(len=10) :: axes
      integer :: i, k
      axes = 'space axes'
      if (found%in_lvlh) axes = 'LVLH frame'
      call page%item('equilibria', count_text(size(found%items))//' attitudes, relative to the '//axes)
      call page%item('by index', count_text(found%number_of(0))//' minima, '// &
                     count_text(found%number_of(1))//' and '//count_text(found%number_of(2))// &
                     ' saddles (index 1, 2), '//count_text(found%number_of(3))//' maxima')
      call page%item('stable', plural(int(count(.not. found%items%growth > 0.0_wp), long), 'attitude')// &
                     ' to first order, of which those of index 0 by the energy')
      if (.not. found%balanced) call page%item('incomplete', &
         'the numbers of equilibria with even and odd index differ: some are missing')
      call page%line('')
      table%indent = 2
      do k = 1, 4
         call table%add_column(components(k), digits=digits)
      end do
      call table%add_column('energy (J)', digits=digits)
      call table%add_column('index')
      call table%add_column('growth (1/s)', digits=digits)
      do i = 1, size(found%items)
         call table%add_row()
         do k = 1, 4
            call table%put(without_rounding(found%items(i)%q(k), negligible))
         end do
         call table%put(found%items(i)%energy)
         call table%put(count_text(found%items(i)%index))
         call table%put(found%items(i)%growth)
      end do
      call page%line(table%text())
   end subroutine add_equilibria

   !> Returns a number, or 0 if it is not above some size.
   pure real(wp) function without_rounding(x, least)
      real(wp), intent(in) :: x, least
      without_rounding = merge(x, 0.0_wp, abs(x) > least)
   end function without_rounding

   !> Linearises the motion of a scene, shows the result, and writes it.
   subroutine linearize_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      type(linearization_t) :: linear
      type(equilibria_t) :: found
      type(page_t) :: page
      type(status_t) :: status
      logical :: to_output

      call load_scene(command, scene, exit_code)
      if (exit_code == EXIT_SUCCESS) call check_names(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      scene%plan%max_steps = command%max_steps
      if (command%equilibria) then
         call scene_equilibria(scene, found, status)
      else
         call linearize_scene(scene, command%period, linear, status)
         if (status%ok() .and. command%relative_rates) call linear%use_relative_rates(status)
      end if
      if (.not. status%ok()) then
         call say_error('nutate: '//printable_path(scene%file)//': '//trim(status%message))
         exit_code = merge(EXIT_INPUT, EXIT_RUN, status%code == NUTATE_BAD_ARGUMENT)
         return
      end if
      to_output = .false.
      if (allocated(command%json)) to_output = command%json == '-'
      call page%line(printable_path(scene%file)//': '//scene%title)
      call add_space_axes(page, scene)
      if (command%equilibria) then
         call add_equilibria(page, found)
      else
         call add_linearization(page, linear)
      end if
      if (.not. command%quiet) call show_page(page, merge(STANDARD_ERROR, STANDARD_OUTPUT, to_output), exit_code)
      if (.not. allocated(command%json)) return
      if (command%equilibria) call write_whole(json_of_equilibria(found), command%json, exit_code)
      if (.not. command%equilibria) call write_whole(json_of(linear), command%json, exit_code)
   end subroutine linearize_command

   !> Rejects file names that would overwrite an input, a file of another kind or each other.
   subroutine check_names(command, scene, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      integer, intent(inout) :: exit_code
      type(outputs_t) :: files
      call files%read_scene(scene)
      if (allocated(command%json)) call files%add(command%json, LINEARIZATION)
      call files%report(exit_code)
   end subroutine check_names

end module nutate_linearize_command
