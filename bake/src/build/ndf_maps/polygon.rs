//! Convex polygons, cut by half planes.

/// The half plane `constant + slope · p > 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfPlane {
    pub constant: f64,
    pub slope: [f64; 2],
}

impl HalfPlane {
    fn at(&self, p: [f64; 2]) -> f64 {
        self.constant + self.slope[0] * p[0] + self.slope[1] * p[1]
    }

    fn flipped(&self) -> Self {
        Self {
            constant: -self.constant,
            slope: self.slope.map(|x| -x),
        }
    }
}

/// A convex polygon by its corners in order; empty if it has none.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polygon(pub Vec<[f64; 2]>);

impl Polygon {
    /// The part in `half` (Sutherland and Hodgman).
    pub fn cut(&self, half: &HalfPlane) -> Self {
        let mut kept = Vec::with_capacity(self.0.len() + 1);
        for (place, &corner) in self.0.iter().enumerate() {
            let next = self.0[(place + 1) % self.0.len()];
            let (here, there) = (half.at(corner), half.at(next));
            if here > 0.0 {
                kept.push(corner);
            }
            if (here > 0.0) != (there > 0.0) {
                let share = here / (here - there);
                kept.push([0, 1].map(|axis| corner[axis] + share * (next[axis] - corner[axis])));
            }
        }
        if kept.len() < 3 {
            kept.clear();
        }
        Self(kept)
    }

    /// What is left of it without the intersection of `halves`, in convex pieces.
    pub fn without(&self, halves: &[HalfPlane]) -> Vec<Self> {
        let mut pieces = Vec::new();
        let mut inside = self.clone();
        for half in halves {
            let outside = inside.cut(&half.flipped());
            if !outside.0.is_empty() {
                pieces.push(outside);
            }
            inside = inside.cut(half);
            if inside.0.is_empty() {
                break;
            }
        }
        pieces
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        let Some((&origin, others)) = self.0.split_first() else {
            return 0.0;
        };
        let from = |p: [f64; 2]| [p[0] - origin[0], p[1] - origin[1]];
        let twice: f64 = others
            .windows(2)
            .map(|pair| {
                let (p, q) = (from(pair[0]), from(pair[1]));
                p[0] * q[1] - p[1] * q[0]
            })
            .sum();
        0.5 * twice.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_and_what_is_taken_make_up_the_whole() {
        let square = Polygon(vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        let halves = [
            HalfPlane {
                constant: -1.0,
                slope: [1.0, 0.2],
            },
            HalfPlane {
                constant: 3.0,
                slope: [-1.0, 0.1],
            },
            HalfPlane {
                constant: -0.5,
                slope: [0.3, 1.0],
            },
        ];
        let taken = halves
            .iter()
            .fold(square.clone(), |part, half| part.cut(half));
        let left: f64 = square.without(&halves).iter().map(Polygon::area).sum();
        assert!(taken.area() > 1.0);
        assert!((left + taken.area() - 16.0).abs() < 1e-12);
    }
}
