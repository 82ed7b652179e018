//! The last touch on rendered text.

/// Rendered Verilog with its port lists aligned and its final newline, which the engine drops.
pub(crate) fn finish(rendered: Result<String, askama::Error>) -> String {
    let rendered = rendered.expect("a template writes to a string");
    let mut lines: Vec<String> = rendered.lines().map(str::to_owned).collect();
    let mut start = 0;
    while start < lines.len() {
        let ports = lines[start..]
            .iter()
            .take_while(|line| Port::of(line).is_some())
            .count();
        align(&mut lines[start..start + ports]);
        start += ports.max(1);
    }
    lines.push(String::new());
    lines.join("\n")
}

/// `  input  wire [range] name...`
struct Port<'a> {
    direction: &'a str,
    range: &'a str,
    rest: &'a str,
}

impl<'a> Port<'a> {
    fn of(line: &'a str) -> Option<Self> {
        let direction = ["  input  wire ", "  output wire "]
            .into_iter()
            .find(|d| line.starts_with(d))?;
        let rest = line[direction.len()..].trim_start();
        let range = match rest.strip_prefix('[') {
            Some(inside) => &rest[..inside.find(']')? + 2],
            None => "",
        };
        Some(Self {
            direction,
            range,
            rest: rest[range.len()..].trim_start(),
        })
    }
}

fn align(lines: &mut [String]) {
    let width = lines
        .iter()
        .filter_map(|l| Port::of(l))
        .map(|p| p.range.len())
        .max()
        .unwrap_or(0);
    for line in lines {
        let Some(port) = Port::of(line) else { continue };
        let gap = if width == 0 { "" } else { " " };
        *line = format!("{}{:width$}{gap}{}", port.direction, port.range, port.rest);
    }
}
