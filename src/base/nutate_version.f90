!> The version of nutate. It is owned by `fpm.toml`, from which `tools/lint/version.py` writes it here.
module nutate_version
   implicit none
   private

   public :: version

   character(len=*), parameter :: version = '0.1.0'

end module nutate_version
