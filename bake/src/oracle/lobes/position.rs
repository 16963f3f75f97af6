//! The position of lobes under a Gaussian footprint: `S = A + Σp` with `A = σh² I`, as sums of squares.

use super::super::double_double::DoubleDouble;
use core::f64::consts::PI;

/// Position of the lobes less that of the footprint: a Gaussian of covariance S, in texels.
pub(in crate::oracle) struct Position {
    /// σh².
    lobe: f64,
    /// The factors f of `Σp = Σ f fᵀ`: half of each edge.
    factors: [[DoubleDouble; 2]; 2],
    /// Σp: variance of x, covariance, variance of y.
    footprint: [f64; 3],
    /// det Σp.
    area: f64,
    /// det S = σh⁴ + σh² tr Σp + det Σp.
    determinant: f64,
}

impl Position {
    pub(in crate::oracle) fn new(deviation: f64, factors: [[DoubleDouble; 2]; 2]) -> Self {
        let lobe = deviation * deviation;
        let entry = |i: usize, j: usize| {
            (factors[0][i] * factors[0][j] + factors[1][i] * factors[1][j]).value()
        };
        let footprint = [entry(0, 0), entry(0, 1), entry(1, 1)];
        let cross = (factors[0][0] * factors[1][1] - factors[0][1] * factors[1][0]).value();
        let area = cross * cross;
        Self {
            lobe,
            factors,
            footprint,
            area,
            determinant: lobe * (lobe + footprint[0] + footprint[2]) + area,
        }
    }

    /// Variances of x and y under S.
    pub(in crate::oracle) fn variances(&self) -> [f64; 2] {
        [self.lobe + self.footprint[0], self.lobe + self.footprint[2]]
    }

    /// Mean of x at the distance `y`, under S.
    pub(in crate::oracle) fn middle(&self, y: DoubleDouble) -> DoubleDouble {
        let [[x_1, y_1], [x_2, y_2]] = self.factors;
        let variance = DoubleDouble::from(self.lobe) + y_1 * y_1 + y_2 * y_2;
        (x_1 * y_1 + x_2 * y_2) / variance * y
    }

    /// Deviation of x at any one y, under S.
    pub(in crate::oracle) fn row_deviation(&self) -> f64 {
        libm::sqrt(self.determinant / self.variances()[1])
    }

    /// The deviation of one axis given the other, `given`, under Σp.
    pub(in crate::oracle) fn footprint_conditional(&self, given: usize) -> f64 {
        let variance = self.footprint[2 * given];
        if variance > 0.0 {
            libm::sqrt(self.area / variance)
        } else {
            libm::sqrt(self.footprint[2 - 2 * given])
        }
    }

    /// The least deviation of Σp in any direction, with x and y in units of `tile` texels.
    pub(in crate::oracle) fn least_footprint_deviation(&self, tile: [f64; 2]) -> f64 {
        let trace =
            self.footprint[0] / (tile[0] * tile[0]) + self.footprint[2] / (tile[1] * tile[1]);
        let area = self.area / (tile[0] * tile[0] * tile[1] * tile[1]);
        // The greater root of `x² - trace x + area`, and the product of both.
        let greatest = 0.5 * (trace + libm::sqrt((trace * trace - 4.0 * area).max(0.0)));
        if greatest > 0.0 {
            libm::sqrt(area / greatest)
        } else {
            0.0
        }
    }

    /// `f × d`: it cancels where d lies along a needle, and is all that is left of such a d.
    fn turns(&self, d: [DoubleDouble; 2]) -> [f64; 2] {
        self.factors.map(|f| (f[0] * d[1] - f[1] * d[0]).value())
    }

    /// `N(d; 0, S)` for the distance d from a lobe to the footprint's centre.
    pub(in crate::oracle) fn density(&self, d: [DoubleDouble; 2]) -> f64 {
        let [x, y] = d.map(DoubleDouble::value);
        let [first, second] = self.turns(d);
        let adjugate = self.lobe * (x * x + y * y) + first * first + second * second;
        libm::exp(-0.5 * adjugate / self.determinant) / (2.0 * PI * libm::sqrt(self.determinant))
    }

    /// `K d = A S⁻¹ d`: where in the lobe the footprint looks on average.
    pub(in crate::oracle) fn look(&self, d: [DoubleDouble; 2]) -> [f64; 2] {
        let turns = self.turns(d);
        let share = self.lobe / self.determinant;
        // adj S = σh² I + Σ f⊥ f⊥ᵀ.
        let mut sum = d.map(|x| self.lobe * x.value());
        for (f, turn) in self.factors.iter().zip(turns) {
            sum[0] -= f[1].value() * turn;
            sum[1] += f[0].value() * turn;
        }
        sum.map(|x| share * x)
    }

    /// The columns c of `Q = A S⁻¹ Σp = Σ c cᵀ`, and det Q.
    ///
    /// `adj(S) Σp = σh² Σp + det Σp I`, so that Q is a sum of positive parts too.
    pub(in crate::oracle) fn seen(&self) -> ([[f64; 2]; 4], f64) {
        let along = self.lobe / libm::sqrt(self.determinant);
        let across = libm::sqrt(self.lobe * self.area / self.determinant);
        let [first, second] = self.factors.map(|f| f.map(|x| along * x.value()));
        (
            [first, second, [across, 0.0], [0.0, across]],
            self.lobe * self.lobe * self.area / self.determinant,
        )
    }

    /// σh².
    pub(in crate::oracle) fn lobe(&self) -> f64 {
        self.lobe
    }

    /// Variance of x (axis 0) or y (axis 1) under Σp.
    pub(in crate::oracle) fn footprint_variance(&self, axis: usize) -> f64 {
        self.footprint[2 * axis]
    }
}
