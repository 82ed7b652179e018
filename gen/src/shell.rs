//! A shell that lets a core be placed and routed alone, however many ports it has.

use askama::Template;
use hwgen_spec::design::Design;

use crate::bundle::File;
use crate::text::finish;
use crate::top::USER_BITS;
use crate::{Header, range};

#[derive(Template)]
#[template(path = "shell.v", syntax = "verilog")]
struct ShellContext<'a> {
    module: &'a str,
    provenance: String,
    drive_bits: usize,
    drive_range: String,
    fold_bits: usize,
    fold_range: String,
    s_data_bits: usize,
    m_user_bits: usize,
}

/// The shell of a design: module `<design>_shell` with the ports `clk_i`, `bit_i` and `bit_o`
/// around the instance `u_core`.
pub fn shell(design: &Design, digest: &str) -> File {
    let header = Header {
        design: design.name(),
        prefix: design.prefix(),
        digest,
        device: design.device(),
    };
    let s_data_bits = design.source().data_bits();
    // Beside the data: reset, valid, last and the other side's ready; ready, valid, last and user.
    let drive_bits = s_data_bits + 4;
    let fold_bits = design.sink().data_bits() + 3 + USER_BITS;
    let context = ShellContext {
        module: design.name(),
        provenance: header.provenance(),
        drive_bits,
        drive_range: range(drive_bits),
        fold_bits,
        fold_range: range(fold_bits),
        s_data_bits,
        m_user_bits: USER_BITS,
    };
    header.rtl(
        &format!("{}_shell", design.name()),
        finish(context.render()),
    )
}
