!> The space axes of a scene, in words.
module nutate_axes_words
   use nutate_console, only: page_t, vector_text
   use nutate_scene, only: scene_t
   implicit none
   private

   public :: add_space_axes

contains

   !> Adds the kind of the space axes and their name, or that of the inertial axes to which exports convert.
   subroutine add_space_axes(page, scene)
      type(page_t), intent(inout) :: page
      type(scene_t), intent(in) :: scene
      character(len=:), allocatable :: text, name
      name = ''
      if (scene%labels%space_frame /= '') name = ', '//scene%labels%space_frame
      associate (effects => scene%system%effects)
         if (.not. effects%frame_turns) then
            text = 'inertial'
            if (effects%on_orbit) text = 'inertial, x to the equinox, z north'
            text = text//name
         else if (effects%knows_space_axes()) then
            text = 'LVLH, which rotate at '//vector_text(effects%frame_rate)//' rad/s'
            if (name /= '') text = text//'; inertial axes'//name
         else
            text = 'rotating, at '//vector_text(effects%frame_rate)//' rad/s'//name
         end if
      end associate
      call page%item('space axes', text)
   end subroutine add_space_axes

end module nutate_axes_words
