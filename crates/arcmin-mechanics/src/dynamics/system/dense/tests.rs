use super::*;

#[test]
fn elimination_pivots_and_agrees_with_nalgebra() {
    [5, LARGE].into_iter().for_each(agrees_with_nalgebra);
}

fn agrees_with_nalgebra(n: usize) {
    let mut lin = DenseLinearisation::new(n);
    let mut matrix = nalgebra::DMatrix::<f64>::zeros(n, n);
    let mass: Vec<f64> = [1.0, 2.0, 0.5, 0.0, 3.0].into_iter().cycle().take(n).collect();
    for i in 0..n {
        for j in 0..n {
            // A zero on the diagonal requires a row exchange.
            let k = if i == j { 0.0 } else { ((i * j * 7 + i + j * 3) as f64).sin() };
            let c = ((i * i + 2 * i * j) as f64).cos();
            lin.add_stiffness(i, j, k);
            lin.add_damping(i, j, c);
            matrix[(i, j)] = 2.0 * k + 0.5 * c + if i == j { 3.0 * mass[i] } else { 0.0 };
        }
    }
    let rhs: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
    let mut x = rhs.clone();
    lin.solve(&mass, Weights { mass: 3.0, damping: 0.5, stiffness: 2.0 }, &mut x).unwrap();
    let rhs = nalgebra::DVector::from_vec(rhs);
    let left = (&matrix * nalgebra::DVector::from_vec(x.clone()) - &rhs).norm();
    assert!(left < 1e-12 * rhs.norm(), "{n}: {left:e}");
    // The same factors for another right-hand side, independent of the present matrices.
    lin.clear();
    let mut again: Vec<f64> = x.iter().rev().copied().collect();
    lin.solve_again(&mut again).unwrap();
    let reversed = nalgebra::DVector::from_iterator(n, x.iter().rev().copied());
    let left = (&matrix * nalgebra::DVector::from_vec(again) - &reversed).norm();
    assert!(left < 1e-12 * reversed.norm(), "{n}: {left:e}");
    let expected = matrix.lu().solve(&rhs).unwrap();
    for i in 0..n {
        assert!((x[i] - expected[i]).abs() < 1e-12 * expected.norm(), "{n} {i}");
    }
}

#[test]
fn singular_matrix_is_reported() {
    for n in [2, LARGE] {
        let mut lin = DenseLinearisation::new(n);
        let weights = Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 };
        let mut rhs = vec![1.0; n];
        assert_eq!(lin.solve(&vec![1.0; n], weights, &mut rhs), Err(Singular));
        lin.add_stiffness(0, 0, f64::NAN);
        assert_eq!(lin.solve(&vec![1.0; n], weights, &mut vec![1.0; n]), Err(Singular));
    }
}
