!> The attack at full length: its part of docs/results/hard-cases.md; and one case of it again, stage by stage.
module test_attack_report
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use nutate_kinds, only: wp, pi
   use test_attack_case, only: attack_case_t, draw_case, BODY_TORQUE, DIPOLE, FEEDBACK, GRADIENT, GRAVITY, &
      POLYNOMIAL, SPACE_TORQUE, SPRING
   use test_attack_run, only: attack_case, attack_cases, counts_t, kinds, tally_t, verdict_text
   implicit none
   private

   public :: report_attack, repeat_case

contains

   !> Runs the attack and writes its table; failures go to standard error as they come, with what is not certified.
   subroutine report_attack(seed, stages, passed)
      integer, intent(in) :: seed
      !> Stages to see at least.
      integer, intent(in) :: stages
      logical, intent(out) :: passed
      type(tally_t) :: tally
      integer :: i
      tally%loud = .true.
      call attack_cases(seed, 1, stages, tally)
      write (output_unit, '("Seed ",i0,": ",i0," cases, ",i0," stages, each in both formulations.")') &
         seed, tally%cases, tally%stages
      write (output_unit, '(/,a,/,a)') '| Δt\|Ω\| of the stage | solved | accepted | of these certified '// &
         '| falsely rejected |', '|---|---|---|---|---|'
      do i = 1, size(kinds)
         call write_row(trim(kinds(i)), tally%counts(i, :))
      end do
      associate (all => tally%total())
         call write_row('all', [all])
         write (output_unit, '(/,4(a,i0),a)') 'Wrong roots: ', all%wrong, ' of the certified ones, ', &
            all%wrong_uncertified, ' of the ', all%uncertified, ' others. Unclear: ', all%unclear, '.'
      end associate
      write (output_unit, '("Stages on which the formulations differ: ",i0," certified, ",i0," not certified.")') &
         tally%disagreements, tally%uncertified_disagreements
      write (output_unit, '("Composed steps that differ from their stages: ",i0,".")') tally%composed
      passed = verdict_text(tally) == ''
      if (.not. passed) write (error_unit, '(a)') verdict_text(tally)
   end subroutine report_attack

   !> Writes a row of the table, the formulations together.
   subroutine write_row(kind, counts)
      character(len=*), intent(in) :: kind
      !> Counts of each formulation.
      type(counts_t), intent(in) :: counts(:)
      integer :: accepted
      accepted = sum(counts%at_once + counts%continued)
      write (output_unit, '("| ",a,4(" | ",i0)," |")') kind, sum(counts%stages), accepted, &
         accepted - sum(counts%uncertified), sum(counts%too_careful)
   end subroutine write_row

   !> Runs one case again, with its scene and every stage of it on standard error.
   subroutine repeat_case(seed, number, passed)
      integer, intent(in) :: seed, number
      logical, intent(out) :: passed
      type(attack_case_t) :: item
      type(tally_t) :: tally
      call draw_case(seed, number, item, .true.)
      call write_scene(item)
      tally%loud = .true.
      tally%traced = .true.
      call attack_case(item, 'this case', tally)
      associate (all => tally%total())
         passed = tally%broken + tally%disagreements + tally%composed + all%wrong == 0
         write (error_unit, '("accepted: ",i0,", wrong: ",i0," certified, ",i0," not certified, refused: ",i0,'// &
                '", in vain: ",i0,", unclear: ",i0)') &
            all%at_once + all%continued, all%wrong, all%wrong_uncertified, all%refused, all%too_careful, all%unclear
      end associate
   end subroutine repeat_case

   !> The case as a scene file, which starts at t = 0; there windows of torques shorten steps.
   subroutine write_scene(item)
      type(attack_case_t), intent(in) :: item
      real(wp) :: tensor(3, 3)
      integer :: i
      tensor = item%inertia()
      if (all(abs(item%axes(2:4)) <= 0.0_wp)) then
         call write_line('&body inertia =', item%moments)
      else
         call write_line('&body inertia_tensor =', &
                         [tensor(1, 1), tensor(2, 2), tensor(3, 3), tensor(1, 2), tensor(1, 3), tensor(2, 3)])
      end if
      write (error_unit, '(a,l1)') '   check_triangle = ', item%check_triangle
      do i = 1, item%n_effects
         if (item%effects(i)%kind /= GRAVITY) cycle
         call write_line('   mass = 1 center_of_mass =', item%effects(i)%m)
         exit
      end do
      write (error_unit, '(a)') '/'
      if (any(abs(item%rotor) > 0.0_wp)) call write_group('&rotor momentum =', item%rotor)
      do i = 1, item%n_effects
         call write_effect(item, i)
      end do
      call write_line('&initial quaternion =', item%q)
      call write_group('   angular_velocity =', item%omega)
      write (error_unit, '(a,i0,a,i0)') '&integrator order = ', item%order, ' ! steps: ', item%steps
      call write_line('   time_step =', [item%dt])
      call write_line('   end_time =', [item%steps*item%dt])
      if (item%inverse_j0 > 0.0_wp) call write_line('   auxiliary_inertia =', [1/item%inverse_j0])
      write (error_unit, '(a)') '/'
   end subroutine write_scene

   subroutine write_effect(item, i)
      type(attack_case_t), intent(in) :: item
      integer, intent(in) :: i
      associate (effect => item%effects(i))
         select case (effect%kind)
         case (GRAVITY)
            call write_group('&gravity acceleration =', effect%n)
         case (DIPOLE)
            call write_line('&dipole field =', effect%n)
            call write_group('   moment =', effect%m)
         case (GRADIENT)
            call write_line('&gravity_gradient direction =', effect%n)
            call write_group('   strength =', [effect%strength])
         case (SPRING)
            call write_line('&spring body_point =', effect%m)
            call write_line('   anchor =', effect%n)
            call write_line('   stiffness =', [effect%strength])
            call write_group('   rest_length =', [effect%rest_length])
         case (POLYNOMIAL)
            call write_line('! a potential of its own: e ((a.g)**3 - g1 g2), e =', [effect%strength])
            call write_line('!    a =', effect%m)
            call write_line('!    direction =', effect%n)
            write (error_unit, '(a,l1)') '!    bounds: ', effect%bounded
         case (FEEDBACK)
            call write_line('! a torque of its own: e cos(2 pi f t + phase) (a.g) g, e =', [effect%strength])
            call write_line('!    a =', effect%m)
            call write_line('!    direction =', effect%n)
            call write_line('!    f, phase =', [effect%frequency, effect%phase + 2*pi*effect%frequency*item%t])
            write (error_unit, '(a,l1)') '!    bounds: ', effect%bounded
         case (BODY_TORQUE, SPACE_TORQUE)
            if (effect%kind == BODY_TORQUE) call write_line('&torque body =', effect%n)
            if (effect%kind == SPACE_TORQUE) call write_line('&torque space =', effect%n)
            if (effect%stop < huge(1.0_wp)) then
               call write_line('   start =', [effect%start - item%t])
               call write_line('   stop =', [effect%stop - item%t])
            end if
            call write_line('   frequency =', [effect%frequency])
            call write_group('   phase =', [effect%phase + 2*pi*effect%frequency*item%t])
         case default
            call write_group('&damping coefficient =', effect%m)
         end select
      end associate
   end subroutine write_effect

   subroutine write_line(text, values)
      character(len=*), intent(in) :: text
      real(wp), intent(in) :: values(:)
      write (error_unit, '(a,*(1x,es26.17e3))') text, values
   end subroutine write_line

   !> A line that ends its group.
   subroutine write_group(text, values)
      character(len=*), intent(in) :: text
      real(wp), intent(in) :: values(:)
      call write_line(text, values)
      write (error_unit, '(a)') '/'
   end subroutine write_group

end module test_attack_report
