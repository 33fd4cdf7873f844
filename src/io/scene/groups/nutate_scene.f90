!> Scenes: reads a scene file, checks every word of it, and builds the scene that it describes.
!>
!> The work is done in steps, each a module of its own: the text is read (`nutate_text_file`), cut into tokens
!> (`nutate_scene_lexer`), checked against the tables of keys (`nutate_scene_check`), and built part by part
!> (`nutate_scene_body`, `..._initial`, `..._effects`, `..._integrator`, `..._output`). The submodule
!> `nutate_scene_building` calls them in this order; the first error ends it.
module nutate_scene
   use nutate_body, only: body_t
   use nutate_chaos_settings, only: chaos_settings_t
   use nutate_effect_list, only: effect_list_t
   use nutate_ensemble_plan, only: ensemble_plan_t
   use nutate_event_list, only: event_list_t
   use nutate_fit_plan, only: fit_plan_t
   use nutate_keys, only: group_t, group_kind_t
   use nutate_periodic_start, only: periodic_start_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_labels, only: labels_t
   use nutate_scene_output, only: output_settings_t
   use nutate_propagated, only: propagated_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: scene_t, output_settings_t, read_scene, parse_scene, changed_part, keep_added, rebuild_scene, scene_kinds

   !> A scene (input file), checked and built: everything that a run needs.
   type :: scene_t
      !> File name without folder and `.nml`.
      character(len=:), allocatable :: name
      !> Path as given.
      character(len=:), allocatable :: file
      !> Title; the name if the scene gives none.
      character(len=:), allocatable :: title
      !> Epoch of t = 0, and names for other programs.
      type(labels_t) :: labels
      !> Name of the body's shape; blank if the inertia is given.
      character(len=:), allocatable :: shape
      !> Body and effects.
      type(system_t) :: system
      !> Numbers of potentials and torques that the groups name.
      integer :: named_potentials = 0, named_torques = 0
      !> User-defined potentials and torques, which are added again if the effects are rebuilt.
      type(effect_list_t) :: added
      !> The body before an ensemble varies it: the gains of controllers refer to it.
      type(body_t), allocatable :: nominal
      !> State at t = 0.
      type(state_t) :: initial
      !> Periodic motion of a resonance at t = 0; otherwise without revolutions.
      type(periodic_start_t) :: periodic
      !> Settings; with an accuracy goal the method may be `auto` and the order 0: the run chooses them.
      type(integrator_settings_t) :: integrator
      !> Time step or accuracy goal, end time, output points.
      type(run_plan_t) :: plan
      type(output_settings_t) :: output
      !> Events.
      type(event_list_t) :: events
      !> Indicators of chaos that runs compute, if any.
      type(chaos_settings_t) :: chaos
      !> Ensemble of the scene, if any.
      type(ensemble_plan_t) :: ensemble
      !> Free parameters and measurements of a fit.
      type(fit_plan_t) :: fit
      !> Groups as given, in the order of the file, overrides applied; shape (number of groups).
      type(group_t), allocatable :: groups(:)
   contains
      !> Returns the free parameters and exponents that runs propagate.
      procedure :: propagated
   end type scene_t

   interface

      !> Reads a scene file.
      !>
      !> Errors: `NUTATE_IO` if the file cannot be read, `NUTATE_BAD_SCENE` for any error in it or in an override.
      module subroutine read_scene(path, scene, status, message, overrides)
         character(len=*), intent(in) :: path
         type(scene_t), intent(out) :: scene
         type(status_t), intent(out) :: status
         !> Error message, one printable line: `FILE:LINE: ...`, `override: ...`, `override with '-': ...` or `FILE:
         !> cannot be read (...)`; empty on success.
         character(len=:), allocatable, intent(out) :: message
         !> `GROUP.KEY=VALUE` or `-GROUP.KEY`, applied in order after the file.
         character(len=*), intent(in), optional :: overrides(:)
      end subroutine read_scene

      !> Reads a scene from memory. Errors as for `read_scene`, without `NUTATE_IO` of the file.
      module subroutine parse_scene(text, path, scene, status, message, overrides)
         !> The scene: lines ended by LF or CR LF.
         character(len=*), intent(in) :: text
         !> Name used in messages; its file name is the name of the scene.
         character(len=*), intent(in) :: path
         type(scene_t), intent(out) :: scene
         type(status_t), intent(out) :: status
         !> Error message, one printable line; empty on success.
         character(len=:), allocatable, intent(out) :: message
         !> `GROUP.KEY=VALUE` or `-GROUP.KEY`, applied in order after the text.
         character(len=*), intent(in), optional :: overrides(:)
      end subroutine parse_scene

      !> Returns every group that a scene can have, with its keys.
      module function scene_kinds() result(kinds)
         type(group_kind_t), allocatable :: kinds(:)
      end function scene_kinds

      !> Returns the part to rebuild after numbers of some groups have changed: `ITS_START`, ...
      module pure integer function changed_part(groups, changed) result(part)
         type(group_t), intent(in) :: groups(:)
         !> Numbers of the group change; shape (groups).
         logical, intent(in) :: changed(:)
      end function changed_part

      !> Keeps the user-defined potentials and torques of a scene, which were added after those that its groups name.
      module subroutine keep_added(scene)
         type(scene_t), intent(inout) :: scene
      end subroutine keep_added

      !> Rebuilds a scene after numbers of its groups have changed.
      module subroutine rebuild_scene(scene, part, error)
         !> Scene that has been read; its files are not read again.
         type(scene_t), intent(inout) :: scene
         !> Part to rebuild, from `changed_part`.
         integer, intent(in) :: part
         type(scene_error_t), intent(inout) :: error
      end subroutine rebuild_scene

   end interface

contains

   !> Returns the free parameters and the number of exponents that runs propagate; none if the scene has none.
   pure type(propagated_t) function propagated(self) result(list)
      class(scene_t), intent(in) :: self
      allocate (list%names(0), list%sigma(0))
      list%exponents = self%chaos%exponents
      if (.not. allocated(self%fit%free)) return
      list%names = self%fit%free%name
      list%sigma = self%fit%free%sigma
   end function propagated

end module nutate_scene
