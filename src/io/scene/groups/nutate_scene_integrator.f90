!> `&integrator`: method, step and end time.
module nutate_scene_integrator
   use nutate_admissible, only: FRACTION, NOT_ZERO, POSITIVE, POSITIVE_OR_INFINITE, TIME_STEP
   use nutate_method_choice, only: AUTOMATIC_METHOD
   use nutate_keys, only: group_t, key_t, name_length, KEY_INTEGER, KEY_LOGICAL, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_limits, only: is_countable
   use nutate_methods, only: default_settings, methods
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_scene_error, only: allow_one_of, demand_one_of, scene_error_t
   use nutate_power_series, only: highest_order, least_order
   use nutate_spelling, only: comma_list, count_text, distinct, joined
   use nutate_integrator_settings, only: integrator_settings_t
   implicit none
   private

   public :: integrator_keys, build_integrator

   !> Keys that belong to single methods.
   character(len=name_length), parameter :: of_a_method(5) = [character(len=name_length) :: &
                                                'order', 'series_order', 'formulation', 'conserve', 'projection']

contains

   !> Keys of the scene group `&integrator`. Methods and formulations are those of the table of methods, and the
   !> automatic choice.
   pure function integrator_keys() result(keys)
      type(key_t) :: keys(14)
      character(len=*), parameter :: names(*) = methods%name, formulations(*) = methods%formulation
      character(len=len(names)), parameter :: automatic = AUTOMATIC_METHOD

      keys = [key_t(name='method', kind=KEY_TEXT, choices=joined(distinct([names, automatic]))), &
              key_t(name='order', kind=KEY_INTEGER), &
              key_t(name='series_order', kind=KEY_INTEGER), &
              key_t(name='formulation', kind=KEY_TEXT, choices=joined(distinct(pack(formulations, formulations /= &
              '')))), key_t(name='time_step', range=TIME_STEP, instead_of='accuracy,local_tolerance'), &
              key_t(name='accuracy', range=FRACTION, instead_of='time_step,local_tolerance'), &
              key_t(name='local_tolerance', range=FRACTION, instead_of='time_step,accuracy'), &
              key_t(name='max_step', range=POSITIVE, beside='accuracy,local_tolerance'), &
              key_t(name='end_time', range=NOT_ZERO, required=.true.), &
              key_t(name='auxiliary_inertia', range=POSITIVE_OR_INFINITE), &
              key_t(name='projection', kind=KEY_LOGICAL), &
              key_t(name='conserve', kind=KEY_LOGICAL), &
              key_t(name='tolerance', range=FRACTION), &
              key_t(name='max_iterations', kind=KEY_INTEGER, range=POSITIVE)]
   end function integrator_keys

   !> Builds the integrator settings, and the end time and either step or goal of the plan. With a goal, the run chooses
   !> an automatic method, or order 0 of `nielsen_krenk` (`choose_settings`).
   subroutine build_integrator(group, settings, plan, error)
      type(group_t), intent(in) :: group
      type(integrator_settings_t), intent(out) :: settings
      type(run_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      real(wp) :: j0

      settings = default_settings(trim(group%text('method', merge(AUTOMATIC_METHOD//'         ', 'nielsen_krenk', &
                                                                leaves_method_open(group)))))
      settings%order = group%whole('order', settings%order)
      settings%series_order = group%whole('series_order', settings%series_order)
      settings%formulation = group%text('formulation', settings%formulation)
      settings%projection = group%flag('projection', settings%projection)
      settings%conserve = group%flag('conserve', settings%conserve)
      settings%tolerance = group%number('tolerance', settings%tolerance)
      settings%max_iterations = group%whole('max_iterations', settings%max_iterations)
      settings%max_step = group%number('max_step', settings%max_step)
      if (group%has('auxiliary_inertia')) then
         j0 = group%number('auxiliary_inertia', 1.0_wp)
         if (j0 <= huge(j0)) settings%inverse_auxiliary_inertia = 1/j0
      end if
      if (settings%method == AUTOMATIC_METHOD) then
         call check_automatic()
      else
         call check_series()
      end if
      if (.not. error%raised .and. settings%method /= AUTOMATIC_METHOD) call check_method()
      if (settings%method == 'nielsen_krenk' .and. group%has('accuracy') .and. .not. group%has('order')) &
         settings%order = 0
      if (.not. settings%projection) call check_projection()
      if (.not. error%raised) call build_goal(plan%goal)
      if (.not. error%raised) call build_times()

   contains

      !> Checks the keys of the automatic choice, which excludes keys of single methods.
      subroutine check_automatic()
         integer :: i
         do i = 1, size(of_a_method)
            if (group%has(trim(of_a_method(i)))) call error%raise(group%line_of(trim(of_a_method(i))), &
               trim(of_a_method(i))//" with the method auto, which chooses it", expected='a method by name with it')
         end do
         if (group%has('time_step')) call error%raise(group%line_of('time_step'), 'time_step with the method auto', &
                                                      expected='accuracy or local_tolerance with it')
      end subroutine check_automatic

      !> Checks the order of a series, which has a key of its own: `order` is one of those in the table of methods.
      subroutine check_series()
         if (settings%method == 'taylor') then
            if (group%has('order')) call error%raise(group%line_of('order'), 'order with the method taylor', &
                                                     expected='series_order, or neither')
         else if (group%has('series_order')) then
            call error%raise(group%line_of('series_order'), 'series_order with the method '//trim(settings%method), &
                             expected="method = 'taylor' with it")
         end if
         if (error%raised .or. .not. group%has('series_order')) return
         if (settings%series_order >= least_order .and. settings%series_order <= highest_order) return
         call error%raise(group%line_of('series_order'), &
                          'series_order '//count_text(settings%series_order)//' is not available', &
                          expected=count_text(least_order)//' to '//count_text(highest_order))
      end subroutine check_series

      !> Raises an error for a combination of method, formulation and order that does not exist.
      subroutine check_method()
         character(len=*), parameter :: names(*) = methods%name, formulations(*) = methods%formulation
         integer, parameter :: orders(*) = methods%order
         logical, parameter :: projected(*) = methods%projected, can_project(*) = methods%can_project
         logical :: fits(size(methods))
         character(len=name_length) :: numbers(size(methods))

         fits = names == settings%method .and. formulations == settings%formulation
         if (.not. any(fits)) then
            call error%raise(group%line_of('formulation'), trim(settings%method)//' has no formulation '// &
                             trim(settings%formulation), expected=formulations_text(settings%method))
         else if (.not. any(fits .and. orders > 0)) then
            if (group%whole('order', 0) /= 0) call error%raise( &
               group%line_of('order'), 'order with the method '//trim(settings%method), expected='no order with it')
         else if (.not. any(fits .and. orders == settings%order)) then
            write (numbers, '(i0)') orders
            call error%raise(group%line_of('order'), 'order '//count_text(settings%order)//' is not available', &
                             expected=comma_list(distinct(pack(numbers, fits))))
         end if
         if (error%raised .or. any(fits .and. ((projected .eqv. settings%conserve) .or. can_project))) return
         call error%raise(group%line_of('conserve'), trim(settings%method)//' needs no projection onto the '// &
                          'invariants: it conserves by itself', expected='no conserve with it')
      end subroutine check_method

      !> Returns the formulations that a method can have.
      pure function formulations_text(method) result(text)
         character(len=*), intent(in) :: method
         character(len=:), allocatable :: text
         character(len=*), parameter :: names(*) = methods%name, formulations(*) = methods%formulation
         text = comma_list(distinct(pack(formulations, names == method)))
         if (text == '') text = 'no formulation with this method'
      end function formulations_text

      !> Checks that without the projection q·p is held by a finite auxiliary inertia, which only the 8×8 system has.
      subroutine check_projection()
         if (settings%inverse_auxiliary_inertia <= 0.0_wp) then
            call error%raise(group%line_of('projection'), 'projection = .false. with an infinite auxiliary_inertia', &
                             expected='a finite auxiliary_inertia with it')
         else if (settings%formulation /= 'full') then
            call error%raise(group%line_of('projection'), 'projection = .false. with formulation = '// &
                             trim(settings%formulation), expected="formulation = 'full' with it")
         else if (settings%conserve) then
            call error%raise(group%line_of('projection'), 'projection = .false. with conserve, which keeps |q| = 1', &
                             expected='conserve = .false. with it')
         end if
      end subroutine check_projection

      !> Builds the goal of adaptive steps.
      subroutine build_goal(goal)
         type(run_goal_t), intent(out) :: goal
         character(len=name_length), parameter :: ways(3) = [character(len=name_length) :: &
                                                             'time_step', 'accuracy', 'local_tolerance']
         call demand_one_of(group, ways, error)
         call allow_one_of(group, ways, error)
         if (error%raised) return
         if (group%has('max_step') .and. group%has('time_step')) call error%raise(group%line_of('max_step'), &
            'max_step with fixed steps', expected='accuracy or local_tolerance with it')
         goal%accuracy = group%number('accuracy', 0.0_wp)
         goal%local_tolerance = group%number('local_tolerance', 0.0_wp)
      end subroutine build_goal

      !> Checks step and end time: of one sign, and not too many steps.
      subroutine build_times()

         plan%time_step = group%number('time_step', 1.0_wp)
         plan%end_time = group%number('end_time', 1.0_wp)
         if (plan%goal%active()) then
            plan%time_step = 0.0_wp
            return
         end if
         if ((plan%time_step > 0.0_wp) .neqv. (plan%end_time > 0.0_wp)) then
            call error%raise(group%line_of('end_time'), 'end_time and time_step have opposite signs', &
                             expected='both positive, or both negative to go back in time')
         else if (.not. is_countable(plan%end_time, plan%time_step)) then
            call error%raise(group%line_of('time_step'), 'time_step is too small for end_time', &
                             expected='less than 9e15 steps')
         end if
      end subroutine build_times

   end subroutine build_integrator

   !> Returns true for an accuracy or a local tolerance without a method, and without a key that belongs to one.
   pure logical function leaves_method_open(group)
      type(group_t), intent(in) :: group
      integer :: i
      leaves_method_open = (group%has('accuracy') .or. group%has('local_tolerance')) .and. &
                           .not. (group%has('method') .or. group%has('time_step'))
      do i = 1, size(of_a_method)
         if (group%has(trim(of_a_method(i)))) leaves_method_open = .false.
      end do
   end function leaves_method_open

end module nutate_scene_integrator
