!> Summary of a run, for people.
module nutate_run_summary
   use nutate_scene_loading, only: add_space_axes
   use nutate_chaos, only: chaos_t
   use nutate_console, only: count_text, page_t, plural, rate_text, say_error, vector_text
   use nutate_control_quantities, only: has_controller
   use nutate_decimal, only: rounded_text
   use nutate_effect_list, only: effect_list_t
   use nutate_effect_traits, only: DRIVES_WHEELS
   use nutate_epoch, only: epoch_t
   use nutate_hamiltonian, only: angular_velocity
   use nutate_invariants, only: invariants_t, ALL_COMPONENTS, ALONG_AXIS, ONLY_LENGTH
   use nutate_kinds, only: long, wp
   use nutate_notes, only: note_t
   use nutate_linearize_command, only: add_periodic
   use nutate_printable, only: printable_path
   use nutate_run, only: run_summary_t, run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_run_watcher, only: signal_name, run_watcher_t
   use nutate_scene, only: scene_t
   use nutate_scene_warnings, only: collect_notes
   use nutate_status, only: status_t
   implicit none
   private

   public :: report_checkpoint, report_failure, report_output, report_signal, kept_rows, summary_page, kept_momentum

contains

   !> Reports that the output cannot be written.
   subroutine report_output(scene, status, kept)
      type(scene_t), intent(in) :: scene
      type(status_t), intent(in) :: status
      !> Location of the rows, as `kept_rows` returns it.
      character(len=*), intent(in) :: kept
      call say_error('nutate: cannot write '//output_name(scene)//': '//trim(status%message)//kept)
   end subroutine report_output

   !> Reports that the checkpoint cannot be written or removed.
   subroutine report_checkpoint(what, watcher, status, kept)
      !> Action that failed: `write` or `remove`.
      character(len=*), intent(in) :: what
      type(run_watcher_t), intent(in) :: watcher
      type(status_t), intent(in) :: status
      !> Location of the rows, as `kept_rows` returns it.
      character(len=*), intent(in) :: kept
      call say_error('nutate: cannot '//what//' checkpoint '//printable_path(watcher%checkpoint%file)//': '// &
                     trim(status%message)//kept)
   end subroutine report_checkpoint

   !> Reports when and why a run failed, and the location of its rows.
   subroutine report_failure(scene, watcher, t, summary, status, closing)
      type(scene_t), intent(in) :: scene
      type(run_watcher_t), intent(in) :: watcher
      !> Time reached, s.
      real(wp), intent(in) :: t
      type(run_summary_t), intent(in) :: summary
      type(status_t), intent(in) :: status
      !> Status of closing the history.
      type(status_t), intent(in) :: closing
      call say_error('nutate: '//printable_path(scene%file)//': stopped at t = '//rounded_text(t, 9)//' s after '// &
                     plural(summary%steps, 'step')//': '//trim(status%message)//kept_rows(watcher, closing))
   end subroutine report_failure

   !> Reports by which signal a run was stopped, and when, if it had begun.
   subroutine report_signal(scene, watcher, t, summary, closing)
      type(scene_t), intent(in) :: scene
      type(run_watcher_t), intent(in), optional :: watcher
      !> Time reached, s.
      real(wp), intent(in), optional :: t
      type(run_summary_t), intent(in), optional :: summary
      !> Status of closing the history.
      type(status_t), intent(in), optional :: closing
      character(len=:), allocatable :: line
      line = 'nutate: '//printable_path(scene%file)//': stopped by '//signal_name()
      if (present(watcher)) then
         line = line//' at t = '//rounded_text(t, 9)//' s after '//plural(summary%steps, 'step')// &
                kept_rows(watcher, closing)
         if (.not. watcher%checkpoint_status%ok()) &
            line = line//'; the last checkpoint could not be written: '//trim(watcher%checkpoint_status%message)
      end if
      call say_error(line)
   end subroutine report_signal

   !> Returns the location of the rows of an incomplete history, and how to resume the run.
   function kept_rows(watcher, closing) result(text)
      type(run_watcher_t), intent(in) :: watcher
      !> Status of closing the history.
      type(status_t), intent(in) :: closing
      character(len=:), allocatable :: text
      text = ''
      if (watcher%file%kept_in() == '') return
      if (closing%ok()) then
         text = '; kept '//plural(watcher%rows, 'row')//' up to t = '// &
                rounded_text(watcher%last_row, 9)//' s in '
      else
         text = '; complete rows are in '
      end if
      text = text//printable_path(watcher%file%kept_in())
      if (watcher%checkpoint%written) &
         text = text//' (to continue: --resume '//printable_path(watcher%checkpoint%file)//')'
   end function kept_rows

   !> Returns the summary: steps, times, iterations, and errors of the invariants over the rows.
   function summary_page(scene, watcher, run) result(page)
      type(scene_t), intent(in) :: scene
      type(run_watcher_t), intent(in) :: watcher
      type(run_t), intent(in) :: run
      type(page_t) :: page
      type(note_t), allocatable :: notes(:)
      type(epoch_t) :: last
      integer :: i

      call page%line(printable_path(scene%file)//': '//scene%title)
      if (scene%labels%epoch%is_set()) then
         last = scene%labels%epoch%after(run%state%t)
         call page%item('calendar time', scene%labels%epoch%text()//' to '//last%text()//' '//trim(last%system))
      end if
      call add_space_axes(page, scene)
      call add_periodic(page, scene%periodic)
      call page%item('initial rate', rate_text(norm2(angular_velocity(scene%system, scene%initial))))
      if (run%summary%choice /= '') call page%item('method', trim(run%summary%settings%method)// &
                                                   ', chosen by auto: '//trim(run%summary%choice))
      call add_effort(page, scene, run, watcher%seconds(), real(watcher%row_counts, wp)/real(watcher%rate, wp))
      if (run%summary%settings%conserve) call page%item('projection', 'onto the invariants')
      call add_invariants(page, watcher%invariants, scene%system%effects)
      if (scene%integrator%attitude) call page%item('norm error', rounded_text(watcher%invariants%norm_error, 3))
      call add_works(page, scene%system%effects, run%summary%work)
      if (allocated(run%events)) call add_events(page, watcher, run)
      if (allocated(run%summary%chaos)) call add_chaos(page, run%summary%chaos)
      call page%item('history', plural(watcher%rows, 'row')//' of '// &
                     count_text(watcher%columns%width)//' columns in '//output_name(scene))
      call collect_notes(scene, notes)
      do i = 1, size(notes)
         call page%item('note', notes(i)%text)
      end do
   end function summary_page

   !> Adds steps, times and iterations.
   subroutine add_effort(page, scene, run, seconds, output_seconds)
      type(page_t), intent(inout) :: page
      type(scene_t), intent(in) :: scene
      type(run_t), intent(in) :: run
      !> Wall time, total and for rows, s.
      real(wp), intent(in) :: seconds, output_seconds
      real(wp) :: n, tried
      n = max(real(run%summary%steps, wp), 1.0_wp)
      tried = n
      if (scene%plan%goal%active()) then
         tried = max(n, real(run%summary%parts, wp))
      else if (run%way%begun) then
         tried = real(run%summary%steps + 1, wp)
      end if
      if (scene%plan%goal%active() .and. run%summary%settings%order < 1) then
         call page%item('steps', count_text(run%summary%steps)//' of the closed solution, to t = '// &
                        rounded_text(run%state%t)//' s')
         if (scene%plan%goal%accuracy > 0.0_wp) call add_error(page, scene%plan%goal%accuracy, run)
      else if (scene%plan%goal%active()) then
         call add_control(page, scene%plan, run)
      else
         call page%item('steps', count_text(run%summary%steps)//' of '//rounded_text(scene%plan%time_step)// &
                        ' s, to t = '//rounded_text(run%state%t)//' s')
         if (run%summary%subdivided_steps > 0) &
            call page%item('subdivided steps', count_text(run%summary%subdivided_steps)//', '// &
                           count_text(run%summary%parts)//' steps and parts in all')
         if (run%way%begun) call page%item('shortened steps', '1 more, which ends at an event')
      end if
      if (run%summary%uncertified_steps > 0 .and. has_certificates(scene%system%effects)) &
         call page%item('not certified', count_text(run%summary%uncertified_steps)// &
                        ' of the steps (see docs/explanation/certified-steps.md)')
      call page%item('wall time', rounded_text(seconds, 3)//' s, of which '//rounded_text(output_seconds, 3)// &
                     ' s for output')
      call page%item('time per step', rounded_text(max(seconds - output_seconds, 0.0_wp)*1e9_wp/tried, 3)//' ns')
      if (run%summary%iterations > 0) call page%item( &
         'Newton iterations', rounded_text(real(run%summary%iterations, wp)/n, 3)//' per step, '// &
         count_text(run%summary%most_iterations)//' at most')
   end subroutine add_effort

   !> Returns true if the steps of a scene can be certified: never those with reaction wheels or controllers.
   pure logical function has_certificates(effects)
      type(effect_list_t), intent(in) :: effects
      has_certificates = effects%n_reaction_wheels == 0 .and. .not. has_controller(1, .false., effects)
   end function has_certificates

   !> Adds the number and the error of adaptive steps.
   subroutine add_control(page, plan, run)
      type(page_t), intent(inout) :: page
      type(run_plan_t), intent(in) :: plan
      type(run_t), intent(in) :: run
      call page%item('steps', count_text(run%summary%steps)//' adaptive, to t = '// &
                     rounded_text(run%state%t)//' s; '//count_text(run%summary%subdivided_steps)//' rejected')
      if (run%summary%parts > run%summary%steps) &
         call page%item('shortened steps', count_text(run%summary%parts - run%summary%steps)// &
                        ' more, which end at events')
      if (plan%goal%accuracy > 0.0_wp) then
         call add_error(page, plan%goal%accuracy, run)
      else
         call page%item('error of a step', 'below '//rounded_text(plan%goal%local_tolerance, 3)//' rad')
      end if
   end subroutine add_control

   !> Adds the estimated error, and the requested accuracy.
   subroutine add_error(page, accuracy, run)
      type(page_t), intent(inout) :: page
      !> Requested attitude error, rad.
      real(wp), intent(in) :: accuracy
      type(run_t), intent(in) :: run
      character(len=:), allocatable :: text
      associate (summary => run%summary)
         text = rounded_text(summary%estimate, 3)//' rad of attitude at the end time'
         if (summary%estimate <= accuracy) then
            text = text//', '//rounded_text(accuracy, 3)//' requested'
         else
            text = text//'; the requested '//rounded_text(accuracy, 3)//' is not attainable: '
            if (summary%round_off > accuracy) then
               text = text//'round-off alone contributes '//rounded_text(summary%round_off, 3)
            else if (summary%table_error > 0.5_wp*summary%estimate) then
               text = text//'the distance of the lines in the table of the orbit contributes '// &
                      rounded_text(summary%table_error, 3)
            else
               text = text//'no step size meets it'
            end if
         end if
      end associate
      call page%item('estimated error', text)
   end subroutine add_error

   !> Adds the number and times of each event, whether an event ended the run, and the work of switches.
   subroutine add_events(page, watcher, run)
      type(page_t), intent(inout) :: page
      type(run_watcher_t), intent(in) :: watcher
      type(run_t), intent(in) :: run
      character(len=:), allocatable :: text
      integer :: i
      do i = 1, size(run%events%watched)
         associate (watched => run%events%watched(i))
            text = 'never'
            if (watched%number == 1) text = 'once, at t = '//rounded_text(watched%first_time, 15)//' s'
            if (watched%number > 1) text = count_text(watched%number)//' times, from t = '// &
                                           rounded_text(watched%first_time, 15)//' to '// &
                                           rounded_text(watched%last_time, 15)//' s'
            if (watched%number > 0) text = text//'; found to '//rounded_text(watched%worst, 2)// &
                                           ' s, plus the integration error'
            if (i > run%events%n_asked) then
               if (watched%number > 0 .and. watched%event%name /= '') call page%item( &
                  merge('upper ', 'lower ', watched%event%direction > 0)//trim(watched%event%name), text)
            else
               call page%item("event '"//trim(watched%event%name)//"'", text)
            end if
         end associate
      end do
      if (run%events%stopped) call page%item('end', 'by an event, at t = '//rounded_text(run%state%t, 15)//' s')
      if (abs(run%summary%switch_work) > 0.0_wp) &
         call page%item('work of switches', rounded_text(run%summary%switch_work)// &
                        ' J by potentials switched on and off')
      if (watcher%events%wanted) call page%item('events', plural(watcher%events%rows, 'row')//' in '// &
                                                printable_path(watcher%events%file%name))
   end subroutine add_events

   !> Adds the indicators of chaos.
   subroutine add_chaos(page, chaos)
      type(page_t), intent(inout) :: page
      type(chaos_t), intent(in) :: chaos
      call page%item(trim(merge('Lyapunov exponent ', 'Lyapunov exponents', chaos%n == 1)), &
                     vector_text(chaos%lyapunov())//' 1/s, over '//rounded_text(chaos%time)//' s')
      call page%item('MEGNO', rounded_text(chaos%megno(), 6)//', time-averaged; tends to 2 for regular motion')
      call page%item('FLI', rounded_text(chaos%fli(), 6)//', maximum of ln(|X(t)|/|X(0)|)')
   end subroutine add_chaos

   !> Adds the errors of the invariants.
   subroutine add_invariants(page, invariants, effects)
      type(page_t), intent(inout) :: page
      type(invariants_t), intent(in) :: invariants
      !> Active effects; if the space axes rotate, V - ω·l replaces V.
      type(effect_list_t), intent(in) :: effects
      call page%item('energy residual', rounded_text(invariants%energy_error(), 3)//' of the largest T + |'// &
                     trim(merge('V - omega.l', 'V          ', effects%frame_turns))//'|, '// &
                     rounded_text(invariants%energy_scale)//' J')
      select case (invariants%components)
      case (ALL_COMPONENTS, ALONG_AXIS, ONLY_LENGTH)
         call page%item('momentum error', rounded_text(invariants%momentum_error(), 3)//' of |l|, '// &
                        rounded_text(invariants%momentum_scale)//' N m s ('//kept_momentum(invariants, effects)//')')
      case default
         call page%item('momentum error', kept_momentum(invariants, effects))
      end select
   end subroutine add_invariants

   !> Returns in words the components of the space momentum that the effects conserve.
   function kept_momentum(invariants, effects) result(text)
      type(invariants_t), intent(in) :: invariants
      type(effect_list_t), intent(in) :: effects
      character(len=:), allocatable :: text
      real(wp) :: b(3)
      select case (invariants%components)
      case (ALL_COMPONENTS)
         text = 'all components'
      case (ONLY_LENGTH)
         text = 'its length; the attitude is not integrated'
      case (ALONG_AXIS)
         ! The sign of the axis is arbitrary: its largest component is shown positive.
         text = 'component along '//vector_text( &
                invariants%axis*sign(1.0_wp, invariants%axis(maxloc(abs(invariants%axis), 1))))
      case default
         text = 'not applicable: these effects conserve no component of the angular momentum'
         b = field_of_magnetorquers(effects)
         if (norm2(b) > 0.0_wp) text = &
            'the exact motion conserves the component along the field of the magnetorquers, '// &
                                       vector_text(b/norm2(b))//'; it is not monitored'
      end select
   end function kept_momentum

   !> Returns the field of the magnetorquers, space axes, T, if only magnetorquers, in one field at rest, and wheels
   !> act: m×B is across it. Zero otherwise; shape (3).
   pure function field_of_magnetorquers(effects) result(b)
      type(effect_list_t), intent(in) :: effects
      real(wp) :: b(3), field(3)
      logical :: alone, found
      integer :: i
      b = 0.0_wp
      alone = .not. effects%frame_turns .and. effects%n_potentials + effects%n_off == 0
      do i = 1, effects%n_torques
         if (effects%torques(i)%item%has(DRIVES_WHEELS)) cycle
         call effects%torques(i)%item%own_field(field, found)
         if (.not. norm2(b) > 0.0_wp) b = field
         alone = alone .and. found .and. all(abs(field - b) <= 0.0_wp)
      end do
      if (.not. alone) b = 0.0_wp
   end function field_of_magnetorquers

   !> Adds the work of each effect that can do work: of an inner sphere, whose components have works, their sum.
   subroutine add_works(page, effects, work)
      type(page_t), intent(inout) :: page
      type(effect_list_t), intent(in) :: effects
      !> J; shape (n_works).
      real(wp), intent(in) :: work(:)
      integer :: first, last, i
      first = effects%n_torques + 2*effects%n_reaction_wheels
      last = first + 6*effects%n_spheres
      do i = 1, size(work)
         if (i <= effects%n_torques) then
            ! Masses that stay in the body exert no torque from outside.
            if (effects%torques(i)%item%is_internal) cycle
         end if
         if (i <= first .or. i > last) then
            call page%item('work of '//worker_name(effects, i), rounded_text(work(i))//' J')
         else if (modulo(i - first, 6) == 0) then
            call page%item('work of '//worker_name(effects, i), rounded_text(sum(work(i - 5:i)))//' J')
         end if
      end do
   end subroutine add_works

   !> Returns the name of an effect that does work: of a torque, or `motor 1`, `friction 1`, ... of a wheel, or
   !> `inner sphere 1`, or the dependence on time of potentials and inertia.
   function worker_name(effects, i) result(name)
      type(effect_list_t), intent(in) :: effects
      !> Position among the effects that do work.
      integer, intent(in) :: i
      character(len=:), allocatable :: name
      integer :: k
      if (i <= effects%n_torques) then
         name = torque_name(effects, i)
      else if (effects%depends_on_time .and. i == effects%n_works()) then
         name = 'time-dependent potentials'
         if (effects%varies) name = 'time-dependent inertia'
         if (effects%varies .and. effects%moves) name = 'dependence on time'
      else
         k = (i - effects%n_torques + 1)/2
         if (effects%wheels(k)%component > 0) then
            name = 'inner sphere '//count_text((k - effects%n_reaction_wheels + 2)/3)
            if (effects%wheels(k)%label /= '') name = name//" '"//trim(effects%wheels(k)%label)//"'"
            return
         end if
         name = trim(merge('friction', 'motor   ', i - effects%n_torques == 2*k))//' '//count_text(k)
         if (effects%wheels(k)%label /= '') name = name//" '"//trim(effects%wheels(k)%label)//"'"
      end if
   end function worker_name

   !> Returns the name of a torque: with its label in the scene, or numbered if several have the name.
   function torque_name(effects, i) result(name)
      type(effect_list_t), intent(in) :: effects
      !> Position among the torques.
      integer, intent(in) :: i
      character(len=:), allocatable :: name
      logical :: same(effects%n_torques)
      integer :: k
      name = trim(effects%torques(i)%item%name)
      if (effects%torques(i)%item%label /= '') then
         name = name//" '"//trim(effects%torques(i)%item%label)//"'"
         return
      end if
      same = [(effects%torques(k)%item%name == name, k=1, effects%n_torques)]
      if (count(same) > 1) name = name//' '//count_text(count(same(1:i), kind=long))
   end function torque_name

   !> Returns the name of the history.
   function output_name(scene) result(name)
      type(scene_t), intent(in) :: scene
      character(len=:), allocatable :: name
      name = printable_path(scene%output%file)
      if (name == '-') name = 'standard output'
   end function output_name

end module nutate_run_summary
