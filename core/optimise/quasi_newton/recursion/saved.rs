//! The state of the recursion in a checkpoint.

use super::{Pair, Products, QuasiNewton};
use crate::checkpoint::{Damaged, Record};
use crate::optimise::quasi_newton::history::{Kept, MAX_FIELDS};
use heapless::Vec;

impl QuasiNewton {
    /// Its state in a checkpoint.
    ///
    /// # Errors
    /// [`Damaged`] where not every field plays one part.
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let mut read = self.clone();
        let last = self.history.fields() - 1;
        [&mut read.scale, &mut read.norm, &mut read.slope]
            .into_iter()
            .try_for_each(|number| record.real(number))?;
        record.count(&mut read.direction, last)?;
        record.count(&mut read.preconditioned, last)?;
        let (mut pairs, mut free) = (read.pairs.len(), read.free.len());
        record.count(&mut pairs, self.history.pairs)?;
        record.count(&mut free, MAX_FIELDS)?;
        let pair = Pair::nowhere(self.halves());
        read.pairs.resize(pairs, pair).map_err(|_| Damaged)?;
        read.free.resize(free, 0).map_err(|_| Damaged)?;
        for (index, pair) in read.pairs.iter_mut().enumerate() {
            pair.record(record, index)?;
        }
        let of_pairs = read.pairs.iter_mut().flat_map(|pair| pair.kept.fields_mut());
        record.small_counts(of_pairs.chain(&mut read.free), last)?;
        if !read.every_field_plays_one_part() {
            return Err(Damaged);
        }
        *self = read;
        Ok(())
    }

    fn every_field_plays_one_part(&self) -> bool {
        let of_pairs = self.pairs.iter().flat_map(|pair| pair.kept.fields());
        let parts = of_pairs
            .chain(&self.free)
            .chain([&self.direction, &self.preconditioned]);
        let (count, seen) = parts.fold((0, 0u32), |(count, seen), field| (count + 1, seen | 1 << field));
        let all = self.history.fields();
        (count, seen.count_ones() as usize) == (all, all)
    }
}

impl Pair {
    /// One to be read over, in one field of halves or in two.
    fn nowhere(halves: bool) -> Self {
        Self {
            kept: if halves {
                Kept::Halves(0)
            } else {
                Kept::Full([0; 2])
            },
            own: Products::default(),
            gradient: Products::default(),
            older: Vec::new(),
        }
    }

    /// One after `older` pairs, but for where it is.
    fn record(&mut self, record: &mut Record<'_>, older: usize) -> Result<(), Damaged> {
        self.older
            .resize(older, Products::default())
            .map_err(|_| Damaged)?;
        for products in [&mut self.own, &mut self.gradient]
            .into_iter()
            .chain(&mut self.older)
        {
            record.real(&mut products.s)?;
            record.real(&mut products.z)?;
        }
        Ok(())
    }
}
