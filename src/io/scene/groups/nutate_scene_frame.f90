!> `&frame`: an attitude by time, from a message, for columns and events.
module nutate_scene_frame
   use nutate_attitude_rows, only: attitude_rows_t
   use nutate_checksum, only: checksum
   use nutate_decimal, only: rounded_text
   use nutate_effect_list, only: effect_list_t
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_measured_message, only: read_records
   use nutate_moving_frame, only: has_time, make_frame, moving_frame_t
   use nutate_printable, only: quoted
   use nutate_run_plan, only: run_plan_t
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_labels, only: labels_t
   use nutate_scene_table, only: read_named_file
   implicit none
   private

   public :: frame_keys, build_frames, check_frames

   !> Keys of the scene group `&frame`.
   type(key_t), parameter :: frame_keys(1) = [ &
                             key_t(name='attitude', kind=KEY_TEXT, required=.true.)]

   !> Maximum number of frames.
   integer, parameter :: most_frames = 3

   !> Dates are rounded: t = 0 may be this much before a record, s.
   real(wp), parameter :: at_record = 1e-6_wp

contains

   !> Builds the frames that the groups name, in their order, unless they have been built.
   subroutine build_frames(groups, labels, scene, effects, error)
      !> Groups; the messages that they name are read once.
      type(group_t), intent(inout) :: groups(:)
      !> Epoch and space axes.
      type(labels_t), intent(in) :: labels
      !> Path of the scene.
      character(len=*), intent(in) :: scene
      !> Effects to which the frames are added.
      type(effect_list_t), intent(inout) :: effects
      type(scene_error_t), intent(inout) :: error
      integer :: i, n, far
      n = count(groups%name == 'frame')
      if (n == 0 .or. effects%n_frames > 0) return
      allocate (effects%frames(n))
      do i = 1, size(groups)
         if (groups(i)%name /= 'frame' .or. error%raised) cycle
         effects%n_frames = effects%n_frames + 1
         if (effects%n_frames > most_frames) then
            call error%raise(groups(i)%line, 'a further &frame', expected='at most three')
            return
         end if
         if (.not. allocated(groups(i)%table)) call read_frame(groups(i), labels, effects, scene, error)
         if (.not. error%raised) call make_frame(groups(i)%table%numbers, effects%frames(effects%n_frames), far)
      end do
   end subroutine build_frames

   !> Reads the message of a group. Raises an error, with file and line, if it does not give an attitude between times.
   subroutine read_frame(group, labels, effects, scene, error)
      type(group_t), intent(inout) :: group
      type(labels_t), intent(in) :: labels
      type(effect_list_t), intent(in) :: effects
      character(len=*), intent(in) :: scene
      type(scene_error_t), intent(inout) :: error
      type(attitude_rows_t) :: rows
      type(moving_frame_t) :: frame
      character(len=:), allocatable :: path, text, problem
      logical :: has_place
      integer :: far
      call read_named_file(group, 'attitude', scene, 'an AEM', path, text, error)
      if (error%raised) return
      call read_records(text, path, labels, effects, rows, problem, has_place)
      if (problem /= '') then
         call error%raise(group%line_of('attitude'), problem)
         error%elsewhere = has_place
      else
         call keep_segment(rows)
      end if
      if (error%raised) return
      if (rows%count() < 2) then
         call error%raise_in(path, rows%lines(1), 'no attitude between this record and another (expected two '// &
                             'records or more)')
      else
         ! Far from t = 0 dates may differ where times do not.
         far = findloc(rows%t(2:) > rows%t(:rows%count() - 1), .false., dim=1)
         if (far > 0) call error%raise_in(path, rows%lines(far + 1), 'the time of the scene is that of the record '// &
                                          'before (expected dates that are further apart, or closer to t = 0)')
      end if
      if (error%raised) return
      allocate (group%table)
      allocate (group%table%numbers(merge(8, 5, allocated(rows%omega)), rows%count()))
      group%table%numbers(1, :) = rows%t
      group%table%numbers(2:5, :) = rows%q
      if (allocated(rows%omega)) group%table%numbers(6:, :) = rows%omega
      group%table%checksum = checksum(text)
      call make_frame(group%table%numbers, frame, far)
      if (far > 0) call error%raise_in(path, rows%lines(far), 'the next record is half a turn or more away '// &
                                       '(expected records that are closer)')
   end subroutine read_frame

   !> Keeps the segment that contains t = 0, the later one of two: there is no attitude between segments.
   subroutine keep_segment(rows)
      type(attitude_rows_t), intent(inout) :: rows
      logical, allocatable :: kept(:)
      integer :: i, k
      if (.not. allocated(rows%segments)) return
      k = 1
      do i = 1, rows%count()
         if (rows%t(i) <= at_record) k = rows%segments(i)
      end do
      kept = rows%segments == k
      rows%t = pack(rows%t, kept)
      rows%lines = pack(rows%lines, kept)
      rows%q = reshape(pack(rows%q, spread(kept, 1, 4)), [4, count(kept)])
      if (allocated(rows%omega)) rows%omega = reshape(pack(rows%omega, spread(kept, 1, 3)), [3, count(kept)])
   end subroutine keep_segment

   !> Raises an error for a run that goes beyond a frame.
   subroutine check_frames(groups, effects, plan, error)
      type(group_t), intent(in) :: groups(:)
      type(effect_list_t), intent(in) :: effects
      type(run_plan_t), intent(in) :: plan
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: name, range
      integer :: i, n, line
      n = 0
      line = 0
      do i = 1, size(groups)
         if (groups(i)%name == 'integrator') line = groups(i)%line_of('end_time')
      end do
      do i = 1, size(groups)
         if (groups(i)%name /= 'frame') cycle
         n = n + 1
         name = quoted(groups(i)%text('attitude', ''))
         associate (frame => effects%frames(n))
            range = rounded_text(frame%t(1), 9)//' to '//rounded_text(frame%t(size(frame%t)), 9)//' s'
            if (.not. has_time(frame, 0.0_wp)) then
               call error%raise(groups(i)%line_of('attitude'), 'the records of '//name//' go from '//range, &
                                expected='records that contain t = 0')
            else if (.not. has_time(frame, plan%end_time)) then
               call error%raise(line, 'end_time is outside of the records of '//name, expected=range)
            end if
         end associate
      end do
   end subroutine check_frames

end module nutate_scene_frame
