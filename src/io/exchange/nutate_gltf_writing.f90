!> Writes a moving body as glTF 2.0: a mesh, one animation of its rotation, and all bytes inside of the JSON text.
!>
!> glTF has y up; a node above the body rotates z up to y up, so that the body's rotation is that of nutate, as (x, y,
!> z, w) = (q1, q2, q3, q0). Viewers interpolate rows by a rotation at a constant rate. Times and attitudes have single
!> precision, as glTF demands.
module nutate_gltf_writing
   use, intrinsic :: iso_fortran_env, only: int16, int8, real32
   use nutate_attitude_rows, only: attitude_rows_t, gap_fault
   use nutate_decimal, only: exact_text
   use nutate_export_facts, only: export_facts_t
   use nutate_files, only: output_file_t
   use nutate_kinds, only: wp
   use nutate_printable, only: printable_path
   use nutate_quaternion, only: quat_normalized
   use nutate_spelling, only: count_text, escaped, lower_case
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_surface, only: surface_of, surface_t
   use nutate_version, only: version
   implicit none
   private

   public :: gltf_fault, write_gltf

   !> Codes of the types of numbers in buffers.
   character(len=*), parameter :: A_FLOAT = '5126', A_SHORT = '5123'
   character, parameter :: backslash = achar(92)
   !> Bounds of lengths: others are scaled to 1, since single precision does not hold them, or viewers do not show them.
   real(wp), parameter :: greatest_length = 1e30_wp, least_length = 1e-30_wp

contains

   !> Returns why rows cannot be written; empty if they can.
   pure function gltf_fault(path, rows, facts) result(problem)
      !> Path of the file.
      character(len=*), intent(in) :: path
      type(attitude_rows_t), intent(in) :: rows
      type(export_facts_t), intent(in) :: facts
      character(len=:), allocatable :: problem
      problem = ''
      if (index(lower_case(path), '.glb', back=.true.) == max(len(path) - 3, 1)) then
         problem = printable_path(path)//' is the name of a binary glTF (expected a name such as NAME.gltf)'
      else if (.not. facts%has_body) then
         problem = "glTF needs the body (expected its scene, or inertia, or shape, size and mass of &body)"
      else if (rows%count() < 1) then
         problem = 'there are no rows (expected one or more)'
      else
         problem = gap_fault(rows)
      end if
   end function gltf_fault

   !> Writes the file.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for what `gltf_fault` finds; `NUTATE_IO`, and what was written is in `PATH.partial`.
   subroutine write_gltf(path, rows, facts, speed, status)
      !> Path of the file; `-` is standard output.
      character(len=*), intent(in) :: path
      type(attitude_rows_t), intent(in) :: rows
      type(export_facts_t), intent(in) :: facts
      !> Simulated seconds per second of animation.
      real(wp), intent(in) :: speed
      type(status_t), intent(out) :: status
      type(output_file_t) :: file
      character(len=:), allocatable :: problem
      problem = gltf_fault(path, rows, facts)
      if (problem /= '') then
         status = fail(NUTATE_BAD_ARGUMENT, problem)
         return
      end if
      call file%open(path, status)
      if (status%ok()) call file%put_line(document(rows, facts, speed), status)
      call file%close(status)
   end subroutine write_gltf

   !> Returns the JSON text.
   function document(rows, facts, speed) result(text)
      type(attitude_rows_t), intent(in) :: rows
      type(export_facts_t), intent(in) :: facts
      real(wp), intent(in) :: speed
      character(len=:), allocatable :: text, name
      type(surface_t) :: surface
      real(real32), allocatable :: times(:), rotations(:, :), points(:, :)
      integer :: sizes(4)
      name = 'body'
      if (facts%labels%object /= '') name = facts%labels%object
      surface = surface_of(facts%body, facts%shape, facts%size)
      points = single_points(surface%points)
      call single_rows(rows, speed, times, rotations)
      sizes = 4*[size(times), size(rotations), size(points), (size(surface%corners) + 1)/2]
      text = '{"asset":{"version":"2.0","generator":"nutate '//version//'","extras":{"rotation":"body to space, '// &
             '(x, y, z, w) = (q1, q2, q3, q0); space z is up",'// &
             '"seconds of motion per second":'//exact_text(speed)//'}},'
      text = text//'"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"space axes",'// &
             '"rotation":[-0.7071067811865476,0,0,0.7071067811865476],"children":[1]},'// &
             '{"name":"'//escaped(name, '"'//backslash, backslash)//'","mesh":0,"rotation":'// &
             json_list(rotations(:, 1))//'}],'
      text = text//'"meshes":[{"primitives":[{"attributes":{"POSITION":2},"indices":3,"material":0}]}],'// &
             '"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.62,0.6,0.55,1],"metallicFactor":0,'// &
             '"roughnessFactor":0.8},"doubleSided":true}],'
      text = text//'"animations":[{"name":"rotation","samplers":[{"input":0,"output":1,"interpolation":"LINEAR"}],'// &
             '"channels":[{"sampler":0,"target":{"node":1,"path":"rotation"}}]}],'
      text = text//'"accessors":['// &
             accessor(0, A_FLOAT, size(times), 'SCALAR', bounds(reshape(times, [1, size(times)])))//','// &
             accessor(1, A_FLOAT, size(times), 'VEC4', '')//','// &
             accessor(2, A_FLOAT, size(points, 2), 'VEC3', bounds(points))//','// &
             accessor(3, A_SHORT, size(surface%corners), 'SCALAR', '')//'],'
      text = text//'"bufferViews":['//view(0, sizes, '')//','//view(1, sizes, '')//','// &
             view(2, sizes, ',"target":34962')//','//view(3, sizes, ',"target":34963')//'],'
      text = text//'"buffers":[{"byteLength":'//count_text(sum(sizes))// &
             ',"uri":"data:application/octet-stream;base64,'//base64( &
             [transfer(times, [0_int8]), transfer(rotations, [0_int8]), transfer(points, [0_int8]), &
              corner_bytes(surface%corners)])//'"}]}'
   end function document

   !> Computes times from the first row, and rotations whose neighbours lie on one half of the sphere. Rows that single
   !> precision cannot tell apart are left out.
   subroutine single_rows(rows, speed, times, rotations)
      type(attitude_rows_t), intent(in) :: rows
      real(wp), intent(in) :: speed
      real(real32), allocatable, intent(out) :: times(:), rotations(:, :)
      real(wp) :: q(4), last(4)
      real(real32) :: t
      integer :: i, n
      allocate (times(rows%count()), rotations(4, rows%count()))
      n = 0
      last = 0.0_wp
      do i = 1, rows%count()
         t = real(min((rows%t(i) - rows%t(1))/speed, real(huge(t), wp)), real32)
         if (n > 0) then
            if (t <= times(n)) cycle
         end if
         q = quat_normalized(rows%q(:, i))
         if (dot_product(q, last) < 0.0_wp) q = -q
         last = q
         n = n + 1
         times(n) = t
         rotations(:, n) = flushed([q(2:4), q(1)])
      end do
      times = times(:n)
      rotations = rotations(:, :n)
   end subroutine single_rows

   !> Returns numbers in single precision; those too small for it become zero.
   elemental real(real32) function flushed(x)
      real(wp), intent(in) :: x
      flushed = 0.0_real32
      if (abs(x) >= tiny(flushed)) flushed = real(x, real32)
   end function flushed

   !> Returns points in single precision, scaled if the body is too large or too small.
   pure function single_points(points) result(single)
      real(wp), intent(in) :: points(:, :)
      real(real32) :: single(size(points, 1), size(points, 2))
      real(wp) :: largest
      largest = maxval(abs(points))
      if (largest > greatest_length .or. largest < least_length) then
         single = flushed(points/largest)
      else
         single = flushed(points)
      end if
   end function single_points

   !> Returns corners as two bytes each, padded to whole words.
   pure function corner_bytes(corners) result(bytes)
      integer, intent(in) :: corners(:, :)
      integer(int8), allocatable :: bytes(:)
      integer(int16) :: shorts(2*((size(corners) + 1)/2))
      shorts = 0_int16
      shorts(:size(corners)) = int(reshape(corners, [size(corners)]), int16)
      bytes = transfer(shorts, [0_int8])
   end function corner_bytes

   !> Returns an accessor: one for each buffer view.
   pure function accessor(n, type_of_number, count, shape, rest) result(text)
      integer, intent(in) :: n, count
      character(len=*), intent(in) :: type_of_number, shape, rest
      character(len=:), allocatable :: text
      text = '{"bufferView":'//count_text(n)//',"componentType":'//type_of_number//',"count":'//count_text(count)// &
             ',"type":"'//shape//'"'//rest//'}'
   end function accessor

   !> Returns a buffer view.
   pure function view(n, sizes, rest) result(text)
      integer, intent(in) :: n, sizes(:)
      character(len=*), intent(in) :: rest
      character(len=:), allocatable :: text
      text = '{"buffer":0,"byteOffset":'//count_text(sum(sizes(:n)))//',"byteLength":'// &
             count_text(sizes(n + 1))//rest//'}'
   end function view

   !> Returns least and greatest values.
   pure function bounds(values) result(text)
      real(real32), intent(in) :: values(:, :)
      character(len=:), allocatable :: text
      text = ',"min":'//json_list(minval(values, dim=2))//',"max":'//json_list(maxval(values, dim=2))
   end function bounds

   pure function json_list(values) result(text)
      real(real32), intent(in) :: values(:)
      character(len=:), allocatable :: text
      integer :: i
      text = '['
      do i = 1, size(values)
         if (i > 1) text = text//','
         text = text//exact_text(real(values(i), wp))
      end do
      text = text//']'
   end function json_list

   !> Returns bytes in base 64.
   pure function base64(bytes) result(text)
      integer(int8), intent(in) :: bytes(:)
      character(len=:), allocatable :: text
      character(len=*), parameter :: letters = 'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/'
      integer :: i, k, n, group, digit
      n = size(bytes)
      allocate (character(len=4*((n + 2)/3)) :: text)
      do i = 0, (n + 2)/3 - 1
         group = 0
         do k = 1, 3
            group = 256*group
            if (3*i + k <= n) group = group + iand(int(bytes(3*i + k)), 255)
         end do
         do k = 1, 4
            digit = iand(ishft(group, -6*(4 - k)), 63)
            text(4*i + k:4*i + k) = letters(digit + 1:digit + 1)
         end do
      end do
      k = modulo(3 - modulo(n, 3), 3)
      if (k > 0) text(len(text) - k + 1:) = repeat('=', k)
   end function base64

end module nutate_gltf_writing
