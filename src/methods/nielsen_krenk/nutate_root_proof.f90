!> Accepts or rejects a root of the step's equations, in either form: certified directly, certified by following the
!> branch from Δt = 0, or beyond what can be certified.
module nutate_root_proof
   use nutate_branch_tubes, only: branch_t
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_kinds, only: wp
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_root_certificate, only: all_bounds_t, root_certificate_t
   use nutate_sphere_steps, only: prepare_spheres, sphere_steps_t
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: root_proof_t, CERTIFIED, ENDED, BEYOND_PROOF

   !> Result for a stage: its true root is known; it has none that could be followed; nothing is known.
   integer, parameter :: CERTIFIED = 1, ENDED = 2, BEYOND_PROOF = 3

   !> |b| below which a root of a free body with a positive determinant is the true one. On its axis the branch ends
   !> where λΔt/2 = 1 - |b|², and the growth rate λ is below |Ω| by the triangle rule: at |b| = √2 - 1 at the earliest.
   !> Off the axes it ends later (2e5 bodies drawn at random: the nearest wrong root has |b| = 0.446).
   real(wp), parameter :: surely_true = 0.41_wp
   !> Distance below which two roots are the same: two roots of a stage are never this close if each is certified to be
   !> alone in its ball or tube. There is a margin for round-off of badly conditioned steps.
   real(wp), parameter :: same_root = 1e-6_wp

   !> Accepts or rejects roots from the system, the start of a stage and its length.
   type :: root_proof_t
      !> Root of the stage last followed, the Cayley vector b = ¼Δt Ω̄; shape (3).
      real(wp) :: b(3) = 0.0_wp
      !> Number of lengths tried to find it.
      integer :: tried = 0
      !> Length of a stage, s, and |b|² below which its root is the true one if the determinant of the Jacobian is
      !> positive: most steps need no other test.
      real(wp) :: length = 0.0_wp, near = 0.0_wp
      !> A proof is possible; none has been derived for wheels.
      logical :: applies = .true.
      !> Times between which `length` and `near` hold, s.
      real(wp) :: from = 0.0_wp, to = 0.0_wp
      !> Neither effects nor rotors, and moments of a rigid body.
      logical, private :: is_free = .true.
      !> Bounds depend on the state at the start of the stage: they do not hold for all steps of the same length.
      logical, private :: by_state = .false.
      type(root_certificate_t), private :: certificate
      !> Forces in parts of a stage; not allocated if there are no effects.
      type(discrete_forces_t), allocatable, private :: forces
      !> Inner spheres in parts of a stage.
      type(sphere_steps_t), allocatable, private :: spheres
   contains
      !> Sets a system.
      procedure :: set_up
      !> Returns true if bounds that belong to the step's length certify the root.
      procedure :: holds
      !> Looks for a proof with the bounds at the attitude of the start, then along the branch.
      procedure :: certify
      !> Returns true if a root is the one to which the branch was followed last.
      procedure :: is_root
   end type root_proof_t

contains

   !> Sets a system.
   subroutine set_up(self, system)
      class(root_proof_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      associate (effects => system%effects)
         self%is_free = effects%n_potentials + effects%n_torques + effects%n_rotors + effects%n_spheres == 0 .and. &
                        .not. (system%body%breaks_triangle .or. effects%frame_turns)
         self%applies = effects%n_reaction_wheels == 0
         self%by_state = effects%n_spheres > 0 .or. effects%varies
      end associate
      call self%certificate%set_up(system)
      if (allocated(self%forces)) deallocate (self%forces)
      if (system%effects%n_potentials + system%effects%n_torques + system%effects%n_spheres > 0) then
         allocate (self%forces)
         call self%forces%prepare(system%effects, .true.)
      end if
      call prepare_spheres(system%effects, self%spheres)
      self%length = 0.0_wp
   end subroutine set_up

   !> Returns true if bounds that belong to the step's length certify the root. They hold for all steps of this length.
   logical function holds(self, system, state, dt, window_time, start, root, determinant)
      class(root_proof_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> State at the start of the stage.
      type(state_t), intent(in) :: state
      !> Length of the stage, and time that decides which torques act, s.
      real(wp), intent(in) :: dt, window_time
      !> b0 = ¼Δt J⁻¹(L0 - h) and b; shape (3).
      real(wp), intent(in) :: start(3), root(3)
      !> Determinant of the Jacobian at the root, over that of a very short step.
      real(wp), intent(in) :: determinant
      holds = self%certificate%holds(system, state, dt, window_time, length_of(start), length_of(root))
      self%length = self%certificate%length
      if (self%by_state) self%length = 0.0_wp
      self%near = self%certificate%near
      self%from = self%certificate%steady_from
      self%to = self%certificate%steady_to
      if (.not. self%is_free) return
      self%near = max(self%near, surely_true**2)
      holds = holds .or. (determinant > 0.0_wp .and. length_of(root) < surely_true)
   end function holds

   !> Looks for a proof with the bounds at the attitude of the start, then follows the branch. On `CERTIFIED` the root
   !> is in b unless the given one is certified already.
   subroutine certify(self, system, state, dt, window_time, start, root, verdict)
      class(root_proof_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> State at the start of the stage.
      type(state_t), intent(in) :: state
      !> Length of the stage, and time that decides which torques act, s.
      real(wp), intent(in) :: dt, window_time
      !> b0 = ¼Δt J⁻¹(L0 - h), and the root found, huge if there was none; shape (3).
      real(wp), intent(in) :: start(3), root(3)
      integer, intent(out) :: verdict
      type(all_bounds_t) :: here
      self%tried = 0
      self%b = root
      if (self%certificate%has_bounds()) then
         call certify_by(self, system, state, dt, window_time, start, root, verdict, here)
      else
         call certify_by(self, system, state, dt, window_time, start, root, verdict)
      end if
   end subroutine certify

   !> Looks for a proof as `certify` does, with bounds of all effects for the stage, if there are any.
   subroutine certify_by(self, system, state, dt, window_time, start, root, verdict, here)
      type(root_proof_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      real(wp), intent(in) :: start(3), root(3)
      integer, intent(out) :: verdict
      type(all_bounds_t), intent(inout), optional :: here
      type(branch_t) :: branch
      type(reduced_equations_t) :: equations
      logical :: proved_here
      verdict = CERTIFIED
      call self%certificate%holds_here(system, state, dt, length_of(start), length_of(root), proved_here, here)
      if (proved_here) return
      verdict = BEYOND_PROOF
      if (.not. self%certificate%followable) return
      if (allocated(self%forces)) call self%forces%move_to(equations%forces)
      if (allocated(self%spheres)) call move_alloc(self%spheres, equations%spheres)
      call branch%follow(self%certificate, equations, system, state, dt, window_time, here)
      if (allocated(self%forces)) call equations%forces%move_to(self%forces)
      if (allocated(equations%spheres)) call move_alloc(equations%spheres, self%spheres)
      self%tried = branch%tried
      self%b = branch%b
      if (branch%is_unbounded) return
      verdict = ENDED
      if (branch%part >= 1.0_wp) verdict = CERTIFIED
   end subroutine certify_by

   !> Returns true if a root is the one to which the branch was followed last.
   pure logical function is_root(self, b)
      class(root_proof_t), intent(in) :: self
      !> Shape (3).
      real(wp), intent(in) :: b(3)
      is_root = maxval(abs(b - self%b)) <= same_root
   end function is_root

   !> Returns |v|; huge if it cannot be computed.
   pure real(wp) function length_of(v)
      real(wp), intent(in) :: v(3)
      real(wp), parameter :: greatest = 1e150_wp
      length_of = huge(length_of)
      if (maxval(abs(v)) < greatest) length_of = sqrt(v(1)**2 + v(2)**2 + v(3)**2)
   end function length_of

end module nutate_root_proof
