//! What checks the emitted hardware: simulators, their dumps, and the comparison with a recording.
//!
//! A [`record::Recording`] holds the value of each register after each rising edge of the clock.
//! A [`simulator::Simulator`] replays the same pins on the Verilog and dumps it,
//! and [`compare::compare`] finds the first register that differs.
//! A difference is a result; an error ([`error::SimError`]) means that nothing can be said.
//!
//! ```
//! use hwgen_sim::record::{Recording, Register};
//!
//! let register = Register::uniform("u_dut_part.count_q", 4, 1);
//! let mut recording = Recording::new(vec![register]);
//! recording.push(&[0]);
//! recording.push(&[1]);
//! assert_eq!(recording.clocks(), 2);
//! ```

pub mod compare;
pub mod doctor;
pub mod error;
pub mod explain;
pub mod gtkwave;
pub mod model;
pub mod record;
pub mod session;
pub mod simulator;
pub mod stimulus;
pub mod structure;
pub mod tool;
pub mod trace;
pub mod vcd;
pub mod verify;
pub mod work;
