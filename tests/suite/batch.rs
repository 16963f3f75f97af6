//! Batches: the same answers as one query at a time, and errors that name the query.

use glintbake_format::model::{Filter, Footprint, HalfVector, Wrap};
use glintbake_runtime::{BatchError, Ndf, Package, Queries, QueryError};
use glintbake_samples::Kind;
use glintbake_tests::fixtures::{Stream, flake_package, sample_map, specular_package};

/// Queries as arrays of their coordinates: centres, edges, half vectors.
fn arrays(queries: &[(Footprint, HalfVector)]) -> [Vec<f64>; 8] {
    let mut arrays = [const { Vec::new() }; 8];
    for (footprint, h) in queries {
        let [[u, v], [e1u, e1v], [e2u, e2v]] =
            [footprint.centre, footprint.edge_1, footprint.edge_2];
        for (array, value) in arrays.iter_mut().zip([u, v, e1u, e1v, e2u, e2v, h.s, h.t]) {
            array.push(value);
        }
    }
    arrays
}

fn queries(arrays: &[Vec<f64>; 8]) -> Queries<'_> {
    let [u, v, e1u, e1v, e2u, e2v, s, t] = arrays;
    Queries {
        centre: [u, v],
        edge_1: [e1u, e1v],
        edge_2: [e2u, e2v],
        half_vector: [s, t],
    }
}

#[test]
fn a_batch_answers_as_its_queries_do() {
    let map = sample_map(Kind::Flakes, 200, 120, 4, Wrap::Repeat);
    for bytes in [flake_package(&map, &[0.05]), specular_package(&map, 31)] {
        let package = Package::open(&bytes).expect("a fresh package opens");
        for filter in [Filter::Box, Filter::Gaussian] {
            let ndf = package
                .ndf(1)
                .expect("it has one instance")
                .with_filter(filter);
            let mut stream = Stream::new(6);
            let list: Vec<_> = (0..60)
                .map(|number| {
                    let footprint = stream.footprint(&map, 2.0 + f64::from(number));
                    let h = stream.half_vector_near(&map, &footprint, 0.02);
                    (footprint, h)
                })
                .collect();
            let arrays = arrays(&list);
            let mut densities = vec![f64::NAN; list.len()];
            let mut pdfs = densities.clone();
            ndf.eval_batch(&queries(&arrays), &mut densities)
                .expect("in range");
            ndf.pdf_batch(&queries(&arrays), &mut pdfs)
                .expect("in range");
            for (((footprint, h), density), pdf) in list.iter().zip(densities).zip(pdfs) {
                assert_eq!(ndf.eval(footprint, *h), Ok(density));
                assert_eq!(ndf.pdf(footprint, *h), Ok(pdf));
            }
        }
    }
}

#[test]
fn a_batch_names_the_query_that_has_no_answer_and_answers_those_before() {
    let map = sample_map(Kind::Flakes, 64, 64, 4, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.1]);
    let package = Package::open(&bytes).expect("a fresh package opens");
    let ndf = package.ndf(1).expect("it has one instance");
    let footprint = Footprint::square([0.4, 0.3], 6.0, 64, 64);
    let h = HalfVector { s: 0.0, t: 0.0 };
    let mut arrays = arrays(&[(footprint, h); 5]);
    arrays[0][3] = f64::NAN;
    let mut densities = [-1.0; 5];
    assert_eq!(
        ndf.eval_batch(&queries(&arrays), &mut densities),
        Err(BatchError::Query {
            index: 3,
            error: QueryError::NotFinite
        })
    );
    let expected = ndf.eval(&footprint, h).expect("in range");
    assert_eq!(densities, [expected, expected, expected, -1.0, -1.0]);
}

#[test]
fn a_batch_of_uneven_arrays_is_refused_and_an_empty_one_is_not() {
    let map = sample_map(Kind::Flakes, 64, 64, 4, Wrap::Repeat);
    let bytes = flake_package(&map, &[0.1]);
    let package = Package::open(&bytes).expect("a fresh package opens");
    let ndf = package.ndf(1).expect("it has one instance");
    let footprint = Footprint::square([0.4, 0.3], 6.0, 64, 64);
    let h = HalfVector { s: 0.0, t: 0.0 };
    let mut uneven = arrays(&[(footprint, h); 2]);
    uneven[7].pop();
    let mut densities = [-1.0; 2];
    let refused = ndf.eval_batch(&queries(&uneven), &mut densities);
    assert_eq!(refused, Err(BatchError::Lengths));
    let even = arrays(&[(footprint, h); 3]);
    let refused = ndf.eval_batch(&queries(&even), &mut densities);
    assert_eq!(refused, Err(BatchError::Lengths));
    assert_eq!(densities, [-1.0; 2]);
    let none = arrays(&[]);
    assert!(queries(&none).is_empty());
    assert_eq!(ndf.eval_batch(&queries(&none), &mut []), Ok(()));
}
