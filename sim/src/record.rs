//! Registers of the core, and their values clock by clock as a model recorded them.

/// One architectural register: a packed vector of words, lane 0 in the lowest bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Register {
    /// Instances and name from the core down, as `u_layer.g_pe[0].u_pe.acc_q`.
    pub path: String,
    /// Bits of each lane, 1 to [`hwgen_spec::format::MAX_WIDTH`]; at least one lane.
    pub lanes: Vec<u32>,
}

impl Register {
    /// A register of `lanes` words of `lane_bits` bits each.
    pub fn uniform(path: impl Into<String>, lane_bits: u32, lanes: usize) -> Self {
        Self {
            path: path.into(),
            lanes: vec![lane_bits; lanes],
        }
    }

    /// Bits of the whole vector.
    pub fn bits(&self) -> u64 {
        self.lanes.iter().map(|bits| u64::from(*bits)).sum()
    }
}

/// The value of every register after each rising edge of the clock.
///
/// Only the lowest bits of a value, as many as its lane has, count, so unsigned counters need no care.
///
/// # Shape
/// `[clock][lane]`, the lanes of all registers one after the other.
#[derive(Clone, Debug)]
pub struct Recording {
    registers: Vec<Register>,
    offsets: Vec<usize>,
    lanes: usize,
    clocks: usize,
    values: Vec<i64>,
}

impl Recording {
    /// An empty recording of these registers.
    pub fn new(registers: Vec<Register>) -> Self {
        let offsets = offsets(&registers);
        let lanes = registers.iter().map(|r| r.lanes.len()).sum();
        Self {
            registers,
            offsets,
            lanes,
            clocks: 0,
            values: Vec::new(),
        }
    }

    /// Makes room for that many clocks more.
    pub fn reserve(&mut self, clocks: usize) {
        self.values.reserve(clocks * self.lanes);
    }

    /// Appends the values after the next rising edge.
    ///
    /// # Panics
    /// If `row` has not one value per lane.
    pub fn push(&mut self, row: &[i64]) {
        assert_eq!(row.len(), self.lanes, "one value per lane");
        self.values.extend_from_slice(row);
        self.clocks += 1;
    }

    /// The registers, in the order of the lanes.
    pub fn registers(&self) -> &[Register] {
        &self.registers
    }

    /// Where the lanes of each register begin in a row.
    pub fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// Lanes of all registers: the length of a row.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// Rising edges recorded.
    pub fn clocks(&self) -> usize {
        self.clocks
    }

    /// All lanes after rising edge `clock`.
    pub fn row(&self, clock: usize) -> &[i64] {
        &self.values[clock * self.lanes..(clock + 1) * self.lanes]
    }

    /// All lanes after rising edge `clock`, to be altered.
    pub fn row_mut(&mut self, clock: usize) -> &mut [i64] {
        &mut self.values[clock * self.lanes..(clock + 1) * self.lanes]
    }

    /// The lanes of one register after rising edge `clock`.
    pub fn values(&self, clock: usize, register: usize) -> &[i64] {
        let start = self.offsets[register];
        &self.row(clock)[start..start + self.registers[register].lanes.len()]
    }
}

pub(crate) fn offsets(registers: &[Register]) -> Vec<usize> {
    registers
        .iter()
        .scan(0, |end, register| {
            let start = *end;
            *end += register.lanes.len();
            Some(start)
        })
        .collect()
}
