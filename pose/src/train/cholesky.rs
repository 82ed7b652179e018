//! Cholesky factors of large matrices, by halves, so that nearly all the work is products.
//!
//! nalgebra's own factorisation goes column by column and is bound by memory at these sizes.
//!
//! # Source
//! F. G. Gustavson, 1997: recursion leads to automatic variable blocking.

use nalgebra::{DMatrix, DMatrixViewMut, DVector};
use rayon::prelude::*;

/// Size below which columns are taken one by one.
const SMALL: usize = 64;

/// Columns of a product that one thread takes at a time.
const STRIP: usize = 128;

/// Puts the factor `L` of `A = L L'` in the place of the lower triangle of `A`.
///
/// False if the matrix is not positive definite; its contents are then of no use.
/// The upper triangle is neither read nor kept.
pub fn factor(matrix: &mut DMatrix<f64>) -> bool {
    let size = matrix.nrows();
    factor_part(matrix, 0, size)
}

/// Factors the diagonal block of a size that starts at `from`.
fn factor_part(matrix: &mut DMatrix<f64>, from: usize, size: usize) -> bool {
    if size <= SMALL {
        return factor_small(&mut matrix.view_mut((from, from), (size, size)));
    }
    let half = (size / 2).div_ceil(SMALL) * SMALL;
    let rest = size - half;
    if !factor_part(matrix, from, half) {
        return false;
    }
    // L21 = A21 L11'^-1, in strips of rows.
    let upper = matrix.view((from, from), (half, half)).transpose();
    let below = matrix.view((from + half, from), (rest, half)).into_owned();
    let strips: Vec<usize> = (0..rest).step_by(STRIP).collect();
    let solved: Vec<DMatrix<f64>> = strips
        .par_iter()
        .map(|&row| {
            let mut strip = below.rows(row, STRIP.min(rest - row)).into_owned();
            solve_right(&mut strip, &upper, 0, half);
            strip
        })
        .collect();
    let mut below = below;
    for (&row, strip) in strips.iter().zip(&solved) {
        below.rows_mut(row, strip.nrows()).copy_from(strip);
    }
    // A22 - L21 L21', the lower triangle in strips of columns.
    let across = below.transpose();
    let products: Vec<DMatrix<f64>> = strips
        .par_iter()
        .map(|&column| {
            let count = STRIP.min(rest - column);
            let mut strip = DMatrix::zeros(rest - column, count);
            let rows = below.rows(column, rest - column);
            strip.gemm(1.0, &rows, &across.columns(column, count), 0.0);
            strip
        })
        .collect();
    for (&column, strip) in strips.iter().zip(&products) {
        let at = (from + half + column, from + half + column);
        let mut place = matrix.view_mut(at, strip.shape());
        place -= strip;
    }
    matrix
        .view_mut((from + half, from), (rest, half))
        .copy_from(&below);
    factor_part(matrix, from + half, rest)
}

/// Factors a small block column by column.
fn factor_small(block: &mut DMatrixViewMut<'_, f64>) -> bool {
    let size = block.nrows();
    for j in 0..size {
        for k in 0..j {
            let factor = block[(j, k)];
            for i in j..size {
                block[(i, j)] -= factor * block[(i, k)];
            }
        }
        let pivot = block[(j, j)];
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let root = pivot.sqrt();
        for i in j..size {
            block[(i, j)] /= root;
        }
    }
    true
}

/// Solves `X U = B` for an upper triangle `U`, the part of `columns` from `from`, in place.
fn solve_right(rows: &mut DMatrix<f64>, upper: &DMatrix<f64>, from: usize, columns: usize) {
    if columns <= SMALL {
        for j in from..from + columns {
            for k in from..j {
                let factor = upper[(k, j)];
                let (left, mut right) = rows.columns_range_pair_mut(k..=k, j..=j);
                right.zip_apply(&left, |r, l| *r -= factor * l);
            }
            rows.column_mut(j).unscale_mut(upper[(j, j)]);
        }
        return;
    }
    let half = (columns / 2).div_ceil(SMALL) * SMALL;
    let rest = columns - half;
    solve_right(rows, upper, from, half);
    let done = rows.columns(from, half).into_owned();
    rows.columns_mut(from + half, rest).gemm(
        -1.0,
        &done,
        &upper.view((from, from + half), (half, rest)),
        1.0,
    );
    solve_right(rows, upper, from + half, rest);
}

/// Solves `L L' x = b` with a factor.
pub fn solve(factor: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let mut x = right.clone();
    factor.solve_lower_triangular_unchecked_mut(&mut x);
    factor.tr_solve_lower_triangular_unchecked_mut(&mut x);
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn definite(size: usize) -> DMatrix<f64> {
        let half = DMatrix::from_fn(size, size + 3, |i, j| {
            ((i * 37 + j * 101 + i * j) % 97) as f64 / 97.0 - 0.5
        });
        &half * half.transpose() + DMatrix::identity(size, size) * 1e-2
    }

    #[test]
    fn solves_small_and_large() {
        for size in [1, 2, 63, 64, 65, 130, 300] {
            let matrix = definite(size);
            let right = DVector::from_fn(size, |i, _| (i % 7) as f64 - 3.0);
            let mut factored = matrix.clone();
            assert!(factor(&mut factored));
            let miss = &matrix * solve(&factored, &right) - &right;
            assert!(
                miss.norm() < 1e-8 * right.norm().max(1.0),
                "{size}: {}",
                miss.norm()
            );
        }
    }

    #[test]
    fn refuses_what_is_not_definite() {
        let mut matrix = definite(130);
        matrix[(100, 100)] = -1.0;
        assert!(!factor(&mut matrix));
    }
}
