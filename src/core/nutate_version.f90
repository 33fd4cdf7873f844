!> The version of nutate; the same as in `fpm.toml`.
module nutate_version
   implicit none
   private

   public :: version

   character(len=*), parameter :: version = '0.1.0'

end module nutate_version
