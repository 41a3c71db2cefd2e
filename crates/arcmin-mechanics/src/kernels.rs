//! Calls of faer's kernels, with the registers cleared afterwards.
//!
//! Kernels of matrix products leave the upper halves of AVX registers in use. Until these are cleared, every
//! SSE2 instruction has a penalty, and the rest of this library is compiled to SSE2 instructions only: code
//! after a product took one and a half times as long, for the life of the thread.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// `into` += or = `factor` × `left` × `right`.
pub(crate) fn product(
    into: MatMut<'_, f64>,
    accumulate: Accum,
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
    factor: f64,
) {
    cleared(|| matmul(into, accumulate, left, right, factor, Par::Seq));
}

/// Calls `work` with faer and clears the registers used by its kernels.
pub(crate) fn cleared<T>(work: impl FnOnce() -> T) -> T {
    let result = work();
    clear();
    result
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn clear() {
    if std::arch::is_x86_feature_detected!("avx") {
        // SAFETY: the check above has found the instruction. It changes upper halves of registers only, in
        // which no value is kept across a call.
        unsafe { std::arch::x86_64::_mm256_zeroupper() };
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn clear() {}

#[cfg(test)]
mod tests {
    use faer::{Accum, mat};

    #[test]
    fn products_add_or_replace() {
        let (left, right) = (mat![[1.0, 2.0], [3.0, 4.0]], mat![[5.0], [6.0]]);
        let mut into = mat![[100.0], [200.0]];
        super::product(into.as_mut(), Accum::Add, left.as_ref(), right.as_ref(), -1.0);
        assert_eq!(into, mat![[83.0], [161.0]]);
        super::product(into.as_mut(), Accum::Replace, left.as_ref(), right.as_ref(), 2.0);
        assert_eq!(into, mat![[34.0], [78.0]]);
    }
}
