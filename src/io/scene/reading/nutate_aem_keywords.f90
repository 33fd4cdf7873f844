!> Keywords of the Attitude Ephemeris Message (CCSDS 504.0-B-2, and 504.0-B-1 for version 1.0), in KVN.
!>
!> The quaternion of version 2.0 converts coordinates of REF_FRAME_A into those of REF_FRAME_B, scalar last: with the
!> space axes as A and the body axes as B it is (q1, q2, q3, q0), without conjugation. Angular velocities are in deg/s.
!>
!> Angular velocities are those of REF_FRAME_B against REF_FRAME_A. The rates of version 1.0 are those of the rotation
!> that the quaternion describes: with ATTITUDE_DIR = B2A that of REF_FRAME_A against REF_FRAME_B.
module nutate_aem_keywords
   use nutate_kinds, only: wp, pi
   use nutate_spelling, only: lower_case
   implicit none
   private

   public :: ANGULAR_VELOCITY, DERIVATIVE, NO_RATES, ROTATION_RATE
   public :: known_keywords, keyword_length, attitude_types, attitude_type_t, ecliptic, equatorial, from_ecliptic, &
      is_ecliptic, is_inertial, is_inverted, is_rotating, standard_frame

   integer, parameter :: keyword_length = 24

   !> Keywords with a value.
   character(len=keyword_length), parameter :: known_keywords(*) = [character(len=keyword_length) :: &
      'CCSDS_AEM_VERS', 'CLASSIFICATION', 'CREATION_DATE', 'ORIGINATOR', 'MESSAGE_ID', 'OBJECT_NAME', 'OBJECT_ID', &
      'CENTER_NAME', 'REF_FRAME_A', 'REF_FRAME_B', 'ATTITUDE_DIR', 'TIME_SYSTEM', 'START_TIME', 'USEABLE_START_TIME', &
      'USEABLE_STOP_TIME', 'STOP_TIME', 'ATTITUDE_TYPE', 'QUATERNION_TYPE', 'EULER_ROT_SEQ', 'ANGVEL_FRAME', &
      'RATE_FRAME', 'INTERPOLATION_METHOD', 'INTERPOLATION_DEGREE']

   !> Kinds of numbers behind the quaternion: none, the angular velocity, the rates of version 1.0, the derivative.
   integer, parameter :: NO_RATES = 0, ANGULAR_VELOCITY = 1, ROTATION_RATE = 2, DERIVATIVE = 3

   !> Type of records that can be read.
   type :: attitude_type_t
      character(len=keyword_length) :: name
      !> Numbers behind the date.
      integer :: numbers
      !> Kind of the numbers behind the quaternion.
      integer :: rates
   end type attitude_type_t

   !> Types with a quaternion.
   type(attitude_type_t), parameter :: attitude_types(4) = [ &
      attitude_type_t('QUATERNION', 4, NO_RATES), &
      attitude_type_t('QUATERNION/ANGVEL', 7, ANGULAR_VELOCITY), &
      attitude_type_t('QUATERNION/DERIVATIVE', 8, DERIVATIVE), &
      attitude_type_t('QUATERNION/RATE', 7, ROTATION_RATE)]

   !> SPICE name of ecliptic axes, which CCSDS does not define; equatorial axes to which they are rotated, and the angle
   !> about their x axis, arcseconds.
   character(len=*), parameter :: ecliptic = 'ECLIPJ2000', equatorial = 'EME2000'
   real(wp), parameter :: obliquity = 84381.448_wp

   !> Names of inertial axes.
   character(len=12), parameter :: inertial_names(*) = [character(len=12) :: &
      'icrf', 'icrf2', 'icrf3', 'gcrf', 'eme2000', 'j2000', 'eclipj2000', 'mod', 'tod', 'teme', 'b1950']

   !> Names of frames that are fixed in a spacecraft, and of frames that are not, without their numbers (SANA registries
   !> of CCSDS 504.0-B; not those of the Moon and other central bodies, which may be the body of a message).
   character(len=*), parameter :: body_frames(*) = [character(len=12) :: 'sc', 'acc', 'actuator', 'ast', 'css', 'dss', &
      'esa', 'gyro', 'imu', 'instrument', 'mta', 'rw', 'sa', 'sensor', 'startracker', 'tam']
   character(len=*), parameter :: space_frames(*) = [character(len=12) :: 'icrf', 'eme2000', 'j2000', 'gcrf', 'itrf', &
      'eclipj2000', 'b1950', 'cirs', 'dtrf', 'efg', 'teme', 'temeofdate', 'temeofepoch', 'tdr', 'tirs', 'tod', 'mod', &
      'moe', 'gtod', 'wgs', 'mci', 'lvlh', 'rsw', 'rtn', 'qsw', 'tnw', 'ntw', 'nsw', 'eqw', 'pqw', 'sez', 'uvw', 'vnc']

   !> Names of axes that rotate, those of orbits and of the Earth, without their numbers; `_INERTIAL` behind them: the
   !> axes of one time.
   character(len=*), parameter :: rotating_names(*) = [character(len=12) :: 'itrf', 'dtrf', 'efg', 'grc', 'gtod', &
      'tdr', 'tirs', 'wgs', 'lvlh', 'rsw', 'rtn', 'qsw', 'tnw', 'ntw', 'nsw', 'sez', 'vnc']

contains

   !> Returns true if only the first of two frames is fixed in the spacecraft.
   pure logical function is_inverted(frame_a, frame_b)
      character(len=*), intent(in) :: frame_a, frame_b
      is_inverted = (is_one_of(body_frames, frame_a) .and. .not. is_one_of(body_frames, frame_b)) .or. &
                    (is_one_of(space_frames, frame_b) .and. .not. is_one_of(space_frames, frame_a))
   end function is_inverted

   !> Returns true for one of some names, in any case, with or without a number.
   pure logical function is_one_of(names, name)
      character(len=*), intent(in) :: names(:), name
      character(len=:), allocatable :: stem
      integer :: i
      stem = lower_case(name)//' '
      i = verify(stem, 'abcdefghijklmnopqrstuvwxyz')
      is_one_of = any(names == stem(:i - 1)) .or. any(names == stem(:scan(stem, ' _') - 1))
   end function is_one_of

   !> Returns one name for frames that have several.
   pure function standard_frame(frame) result(name)
      character(len=*), intent(in) :: frame
      character(len=:), allocatable :: name
      name = frame
      if (lower_case(frame) == 'j2000') name = equatorial
   end function standard_frame

   !> Returns the attitude of ecliptic axes in equatorial ones; shape (4).
   pure function from_ecliptic() result(q)
      real(wp) :: q(4)
      real(wp), parameter :: half = 0.5_wp*obliquity/3600*pi/180
      q = [cos(half), sin(half), 0.0_wp, 0.0_wp]
   end function from_ecliptic

   !> Returns true for the name of ecliptic axes.
   pure logical function is_ecliptic(frame)
      character(len=*), intent(in) :: frame
      is_ecliptic = lower_case(frame) == lower_case(ecliptic)
   end function is_ecliptic

   !> Returns true for the name of inertial axes.
   pure logical function is_inertial(frame)
      character(len=*), intent(in) :: frame
      is_inertial = any(inertial_names == lower_case(frame))
   end function is_inertial

   !> Returns true for the name of axes that rotate.
   pure logical function is_rotating(frame)
      character(len=*), intent(in) :: frame
      is_rotating = is_one_of(rotating_names, frame) .and. index(lower_case(frame), '_inertial') == 0
   end function is_rotating

end module nutate_aem_keywords
