//! Names: of modules and files, and of columns and words of a stream.

use super::check_length;
use crate::json::{Fault, Node};
use crate::keywords;

/// Longest name, in characters.
const MAX_CHARS: usize = 63;

/// What shared layers are called, as if they were a network.
const SHARED: &str = "shared";

/// Words that the generated modules of a design use beside its networks, and what for.
const RESERVED_NETWORKS: &[(&str, &str)] = &[
    (SHARED, "the module of the shared layers has it"),
    ("shared_in", "the layer that scales the inputs has it"),
    ("frames", "the queue of what is known of a frame has it"),
];

/// Name of the design. Its modules are called `<prefix>__<part>`, and the first `__` ends the prefix: so neither
/// name nor prefix may hold one, and designs of different names and prefixes have no module in common.
pub(super) fn design(node: Node<'_>) -> Result<String, Fault> {
    let name = identifier(node)?;
    if name.contains("__") || name.ends_with('_') {
        let message = format!(
            "expected a name without __ and without _ at its end, found {}",
            node.excerpt()
        );
        let fault = node.fault("bad-name", message);
        return Err(match mended(&name) {
            Some(mended) => fault.help(format!(
                "__ ends the prefix of a module's name; try \"{mended}\""
            )),
            None => fault.help("__ ends the prefix of a module's name"),
        });
    }
    Ok(name)
}

/// Whether a text will do as the name of a design or as the prefix of its modules; if not, what was expected and
/// found.
///
/// # Errors
/// If a weights file with this name would be refused.
pub fn check_name(name: &str) -> Result<(), String> {
    let text = serde_json::Value::from(name).to_string();
    let limits = super::LIMITS;
    let told = |fault: Fault| match fault.help {
        Some(help) => format!("{} ({help})", fault.message),
        None => fault.message,
    };
    let node = crate::json::parse(text.as_bytes(), limits).map_err(told)?;
    design(node).map(|_| ()).map_err(told)
}

/// Name of a network that must differ from those before; it joins them.
pub(super) fn network<'a>(
    node: Node<'a>,
    before: &mut Vec<(String, Node<'a>)>,
) -> Result<String, Fault> {
    let lower = text(node)?.to_ascii_lowercase();
    if let Some((_, reason)) = RESERVED_NETWORKS.iter().find(|(word, _)| *word == lower) {
        return Err(reserved(node, reason));
    }
    let name = identifier(node)?;
    if let Some((_, first)) = before.iter().find(|(n, _)| n.eq_ignore_ascii_case(&name)) {
        return Err(duplicate(node, *first).help(
            "network names become module and file names: they must differ in more than case",
        ));
    }
    if is_layer(&name, SHARED) {
        return Err(reserved(node, "a shared layer has it"));
    }
    let layer = |(n, _): &&(String, Node<'_>)| is_layer(&name, n) || is_layer(n, &name);
    if let Some((other, first)) = before.iter().find(layer) {
        let reason = format!(
            "that and \"{other}\" of {} would be network and layer",
            first.path()
        );
        return Err(reserved(node, &reason));
    }
    before.push((name.clone(), node));
    Ok(name)
}

/// Whether a name is that of a layer of a network.
fn is_layer(name: &str, network: &str) -> bool {
    let (name, network) = (name.to_ascii_lowercase(), network.to_ascii_lowercase());
    let rest = name.strip_prefix(&network);
    let number = rest.and_then(|rest| rest.strip_prefix("_l"));
    number.is_some_and(|number| {
        !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())
    })
}

/// Names of inputs or outputs, `<default>0`, `<default>1`, ... where the file gives none.
pub(super) fn ports(
    node: Option<Node<'_>>,
    default: &str,
    count: usize,
    because: &str,
) -> Result<Vec<String>, Fault> {
    let Some(node) = node else {
        return Ok((0..count).map(|i| format!("{default}{i}")).collect());
    };
    let nodes = node.array()?;
    check_length(node, "name", nodes.len(), count, because)?;
    let mut first = std::collections::HashMap::with_capacity(count);
    let mut names = Vec::with_capacity(count);
    for node in nodes {
        let name = shaped(node, "a column's name")?;
        if let Some(first) = first.insert(name.clone(), node) {
            return Err(duplicate(node, first).help("rename one of the two"));
        }
        names.push(name);
    }
    Ok(names)
}

fn text(node: Node<'_>) -> Result<String, Fault> {
    node.string().map_err(|fault| match fault.help {
        None => fault.help("a name is a string in double quotes"),
        Some(_) => fault,
    })
}

/// A name that becomes a module's: well shaped and no keyword.
fn identifier(node: Node<'_>) -> Result<String, Fault> {
    let name = shaped(node, "a Verilog identifier")?;
    if let Some(language) = keywords::reserving_language(&name) {
        let fault = node.fault(
            "keyword",
            format!("a name expected, the {language} keyword \"{name}\" found"),
        );
        return Err(fault.help(format!("choose another name, such as \"{name}_0\"")));
    }
    Ok(name)
}

/// A name of the characters and length that identifiers have.
fn shaped(node: Node<'_>, becomes: &str) -> Result<String, Fault> {
    let name = text(node)?;
    let start = |c: char| c.is_ascii_alphabetic() || c == '_';
    let shaped = name.starts_with(start)
        && name.chars().all(|c| start(c) || c.is_ascii_digit())
        && name.len() <= MAX_CHARS;
    if !shaped {
        let found = match name.chars().count() {
            0 => "an empty one".to_owned(),
            n if n > MAX_CHARS => format!("one of {n} characters"),
            _ => node.excerpt(),
        };
        let fault = node.fault(
            "bad-name",
            format!("a name [A-Za-z_][A-Za-z0-9_]{{0,62}} expected, {found} found"),
        );
        return Err(match mended(&name) {
            Some(mended) => fault.help(format!("it becomes {becomes}; try \"{mended}\"")),
            None => fault.help(format!("it becomes {becomes} of at most 63 characters")),
        });
    }
    Ok(name)
}

/// A name like a refused one that would do.
fn mended(name: &str) -> Option<String> {
    let mut mended = String::new();
    for c in name.chars() {
        let plain = if c.is_ascii_alphanumeric() { c } else { '_' };
        if plain != '_' || !mended.ends_with('_') {
            mended.push(plain);
        }
    }
    mended.truncate(mended.trim_end_matches('_').len());
    if mended.starts_with(|c: char| c.is_ascii_digit()) {
        mended.insert(0, '_');
    }
    let good = mended.len() <= MAX_CHARS
        && mended.contains(|c: char| c.is_ascii_alphanumeric())
        && keywords::reserving_language(&mended).is_none();
    good.then_some(mended)
}

fn duplicate(node: Node<'_>, first: Node<'_>) -> Fault {
    let message = format!(
        "a name unlike that of {} expected, {} found again",
        first.path(),
        node.excerpt()
    );
    node.fault("duplicate-name", message)
}

fn reserved(node: Node<'_>, reason: &str) -> Fault {
    let message = format!("a free name expected, {} found", node.excerpt());
    node.fault("reserved-name", message)
        .help(format!("{reason}; choose another name"))
}
