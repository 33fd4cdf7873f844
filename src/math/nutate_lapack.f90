!> The few LAPACK routines nutate uses: explicit interfaces, and one conversion of `info` to a status.
module nutate_lapack
   use nutate_kinds, only: wp
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_SINGULAR
   implicit none
   private

   public :: dgetrf, dgetrs, dgesv, dgeqrf, dormqr, dgesvd, dptsv, symmetric_eigen, general_eigenvalues, handle_info

   interface
      !> Computes the LU factors of a general matrix, with partial pivoting.
      pure subroutine dgetrf(m, n, a, lda, ipiv, info)
         import :: wp
         integer, intent(in) :: m, n, lda
         real(wp), intent(inout) :: a(lda, *)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgetrf

      !> Solves A X = B with the factors of `dgetrf`.
      pure subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: wp
         character(len=1), intent(in) :: trans
         integer, intent(in) :: n, nrhs, lda, ldb
         real(wp), intent(in) :: a(lda, *)
         integer, intent(in) :: ipiv(*)
         real(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine dgetrs

      !> Factorises and solves A X = B: the yardstick of the benchmarks.
      pure subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: wp
         integer, intent(in) :: n, nrhs, lda, ldb
         real(wp), intent(inout) :: a(lda, *), b(ldb, *)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgesv

      !> Solves A X = B, A symmetric, definite and tridiagonal, given by its diagonal d and its off-diagonal e.
      pure subroutine dptsv(n, nrhs, d, e, b, ldb, info)
         import :: wp
         integer, intent(in) :: n, nrhs, ldb
         real(wp), intent(inout) :: d(*), e(*), b(ldb, *)
         integer, intent(out) :: info
      end subroutine dptsv

      !> Computes the QR factors of a general matrix.
      pure subroutine dgeqrf(m, n, a, lda, tau, work, lwork, info)
         import :: wp
         integer, intent(in) :: m, n, lda, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(out) :: tau(*), work(*)
         integer, intent(out) :: info
      end subroutine dgeqrf

      !> Multiplies C by the Q of `dgeqrf` or by its transpose.
      pure subroutine dormqr(side, trans, m, n, k, a, lda, tau, c, ldc, work, lwork, info)
         import :: wp
         character(len=1), intent(in) :: side, trans
         integer, intent(in) :: m, n, k, lda, ldc, lwork
         real(wp), intent(in) :: a(lda, *), tau(*)
         real(wp), intent(inout) :: c(ldc, *)
         real(wp), intent(out) :: work(*)
         integer, intent(out) :: info
      end subroutine dormqr

      !> Computes the singular values (descending) and vectors of a general matrix.
      pure subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
         import :: wp
         character(len=1), intent(in) :: jobu, jobvt
         integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(out) :: s(*), u(ldu, *), vt(ldvt, *), work(*)
         integer, intent(out) :: info
      end subroutine dgesvd

      !> Eigenvalues and eigenvectors of a symmetric matrix.
      pure subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
         import :: wp
         character(len=1), intent(in) :: jobz, uplo
         integer, intent(in) :: n, lda, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(out) :: w(*), work(*)
         integer, intent(out) :: info
      end subroutine dsyev

      !> Eigenvalues and, if requested, eigenvectors of a general matrix.
      pure subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: wp
         character(len=1), intent(in) :: jobvl, jobvr
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(out) :: wr(*), wi(*), vl(ldvl, *), vr(ldvr, *), work(*)
         integer, intent(out) :: info
      end subroutine dgeev
   end interface

contains

   !> Computes eigenvalues (ascending) and orthonormal eigenvectors (columns) of a symmetric 3×3 matrix (LAPACK
   !> `dsyev`).
   pure subroutine symmetric_eigen(matrix, values, vectors, status)
      !> Symmetric; the upper triangle is read.
      real(wp), intent(in) :: matrix(3, 3)
      real(wp), intent(out) :: values(3), vectors(3, 3)
      type(status_t), intent(out) :: status
      real(wp) :: work(32)
      integer :: info
      vectors = matrix
      call dsyev('V', 'U', 3, vectors, 3, values, work, size(work), info)
      status = handle_info('dsyev', info)
   end subroutine symmetric_eigen

   !> Computes the eigenvalues of a square matrix (LAPACK `dgeev`); conjugate pairs stand together, the positive
   !> imaginary part first.
   pure subroutine general_eigenvalues(matrix, values, status)
      !> Finite; shape (n, n).
      real(wp), intent(in) :: matrix(:, :)
      !> Shape (n).
      complex(wp), intent(out) :: values(:)
      type(status_t), intent(out) :: status
      real(wp) :: a(size(values), size(values)), re(size(values)), im(size(values)), work(34*size(values))
      real(wp) :: left(1, 1), right(1, 1)
      integer :: info
      a = matrix
      call dgeev('N', 'N', size(values), a, size(values), re, im, left, 1, right, 1, work, size(work), info)
      values = cmplx(re, im, wp)
      status = handle_info('dgeev', info)
   end subroutine general_eigenvalues

   !> Returns the status that a LAPACK `info` stands for.
   pure function handle_info(routine, info) result(status)
      !> Name of the LAPACK routine.
      character(len=*), intent(in) :: routine
      !> Value of `info` that the routine returned.
      integer, intent(in) :: info
      type(status_t) :: status
      if (info < 0) then
         status = fail(NUTATE_BAD_ARGUMENT, routine//': an argument is out of range')
      else if (info > 0 .and. routine == 'dsyev') then
         status = fail(NUTATE_NOT_CONVERGED, 'the principal axes of the inertia tensor could not be found')
      else if (info > 0 .and. routine == 'dgesvd') then
         status = fail(NUTATE_NOT_CONVERGED, 'the singular values of the Jacobian could not be found')
      else if (info > 0 .and. routine == 'dgeev') then
         status = fail(NUTATE_NOT_CONVERGED, 'the eigenvalues of the linearised motion could not be found')
      else if (info > 0) then
         status = fail(NUTATE_SINGULAR, 'the linear system of the step is singular')
      end if
   end function handle_info

end module nutate_lapack
