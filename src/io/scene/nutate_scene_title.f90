!> `&scene`: the title, and the name that a scene has from its file.
module nutate_scene_title
   use nutate_keys, only: key_t, KEY_TEXT
   use nutate_spelling, only: lower_case
   implicit none
   private

   public :: title_keys, scene_name

   !> Keys of the scene group `&scene`.
   type(key_t), parameter :: title_keys(1) = [key_t(name='title', kind=KEY_TEXT)]

contains

   !> A path's file name without folder and `.nml`.
   pure function scene_name(path) result(name)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: name
      name = trim(path(index(path, '/', back=.true.) + 1:))
      if (len(name) <= 4) return
      if (lower_case(name(len(name) - 3:)) == '.nml') name = name(1:len(name) - 4)
   end function scene_name

end module nutate_scene_title
