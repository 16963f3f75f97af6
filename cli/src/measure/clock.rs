//! Run times: medians and quartiles over repetitions, by a clock whose own step is known.

use crate::report::document::Timing;
use std::time::Instant;

/// A repetition lasts at least so many steps of the clock.
const LEAST_STEPS: f64 = 1000.0;
/// Starts and ends that the clock's step is sought among.
const TRIALS: usize = 2000;

/// A clock, and how long to measure.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// The smallest step seen between two readings, in seconds.
    pub step: f64,
    /// Seconds that a measurement should take.
    pub seconds: f64,
    /// Repetitions that its median is taken of.
    pub repetitions: usize,
}

impl Clock {
    /// The clock of this machine, for measurements of about `seconds` in `repetitions`.
    pub fn new(seconds: f64, repetitions: usize) -> Self {
        let step = (0..TRIALS)
            .map(|_| {
                let start = Instant::now();
                loop {
                    let elapsed = start.elapsed();
                    if !elapsed.is_zero() {
                        return elapsed.as_secs_f64();
                    }
                }
            })
            .fold(f64::INFINITY, f64::min);
        Self {
            step,
            seconds,
            repetitions,
        }
    }

    /// Times `call`, which is given a number of a query below `queries`: all of them in turn as far as the time goes,
    /// and again from the first if it goes further.
    ///
    /// A repetition times many calls together, so that neither the clock's step nor its cost counts; each begins where
    /// the last has ended, so that slow and fast queries meet all alike. Slow calls have fewer repetitions, three at least.
    pub fn time(&self, queries: usize, mut call: impl FnMut(usize)) -> Timing {
        // What a call takes, from as many as fit into a tenth of the time; they warm caches too.
        let start = Instant::now();
        let mut warmed = 0;
        let estimate = loop {
            call(warmed % queries);
            warmed += 1;
            let elapsed = start.elapsed().as_secs_f64();
            if elapsed > 0.1 * self.seconds && elapsed > LEAST_STEPS * self.step {
                break elapsed / warmed as f64;
            }
        };
        let affordable = self.seconds / estimate;
        let repetitions = self.repetitions.min(affordable as usize).max(3);
        let least = (LEAST_STEPS * self.step / estimate).ceil() as usize;
        let calls = ((affordable / repetitions as f64) as usize)
            .max(least)
            .max(1);
        let mut next = 0;
        let mut times: Vec<f64> = (0..repetitions)
            .map(|_| {
                let start = Instant::now();
                for _ in 0..calls {
                    call(next);
                    next += 1;
                    if next == queries {
                        next = 0;
                    }
                }
                start.elapsed().as_secs_f64() * 1e9 / calls as f64
            })
            .collect();
        times.sort_by(f64::total_cmp);
        Timing {
            median_ns: quantile(&times, 0.5),
            low_ns: quantile(&times, 0.25),
            high_ns: quantile(&times, 0.75),
            repetitions,
            calls,
        }
    }
}

/// The quantile `part` of rising `values`, of which there is at least one; between two, linearly.
pub fn quantile(values: &[f64], part: f64) -> f64 {
    let place = part * (values.len() - 1) as f64;
    let (below, above) = (values[place as usize], values[place.ceil() as usize]);
    below + (above - below) * place.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_values() {
        let values = [1.0, 2.0, 4.0];
        assert_eq!(quantile(&values, 0.0), 1.0);
        assert_eq!(quantile(&values, 0.5), 2.0);
        assert_eq!(quantile(&values, 0.75), 3.0);
        assert_eq!(quantile(&values, 1.0), 4.0);
        assert_eq!(quantile(&[7.0], 0.99), 7.0);
    }

    #[test]
    fn every_query_is_asked_in_turn_and_quartiles_enclose_the_median() {
        let clock = Clock::new(0.002, 5);
        let mut asked = [0_u32; 7];
        let timing = clock.time(7, |query| asked[query] += 1);
        assert!(asked.iter().all(|&count| count > 0));
        assert!(timing.low_ns <= timing.median_ns && timing.median_ns <= timing.high_ns);
        assert!(timing.repetitions >= 3 && timing.calls >= 1);
        assert!(clock.step > 0.0 && clock.step < 0.1);
    }
}
