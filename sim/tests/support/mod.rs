//! A small core for the tests: its Verilog and its bench.

use std::path::{Path, PathBuf};
use std::time::Duration;

use hwgen_sim::simulator::{BuildPlan, Purpose, Text};

/// Writes the bench for `echo`, the sources with `edit` applied, and says how to build them.
pub fn plan(directory: &Path, cache: &Path, edit: impl Fn(&str, String) -> String) -> BuildPlan {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let rtl = package.parent().expect("a workspace").join("rtl");
    let read = |path: &Path| std::fs::read_to_string(path).expect("a file of the project");
    let write = |name: &str, text: &str| -> PathBuf {
        let path = directory.join(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    let bench = |template: &str, name: &str| {
        let text = read(&rtl.join("tpl").join(template))
            .replace("@{ design }@", "echo")
            .replace("@{ s_data_bits }@", "16")
            .replace("@{ m_data_bits }@", "24")
            .replace("@{ m_user_bits }@", "1");
        assert!(!text.contains("@{"), "a placeholder was left");
        Text {
            name: name.to_owned(),
            text,
        }
    };
    let sources = ["echo.v", "echo_sums.v", "echo_pe.v"]
        .map(|name| {
            let text = read(&package.join("tests/data").join(name));
            write(name, &edit(name, text))
        })
        .to_vec();
    BuildPlan {
        design: "echo".to_owned(),
        sources,
        bench: bench("tb.v", "echo_tb.v"),
        bench_icarus: bench("tb_icarus.v", "echo_tb_icarus.v"),
        main_cpp: Text {
            name: "sim_main.cpp".to_owned(),
            text: read(&rtl.join("tb/sim_main.cpp")),
        },
        models: Vec::new(),
        work_dir: directory.to_owned(),
        cache_dir: cache.to_owned(),
        purpose: Purpose::Trace,
        timeout: Duration::from_secs(300),
    }
}
