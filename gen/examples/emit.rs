//! Quick emit.
use hwgen_spec::{design::Design, options::*, weights};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let net = weights::read(&std::fs::read(&a[1]).unwrap()).unwrap();
    let mut o = Options::default();
    if let Some(i) = a.get(3) { o.budget = Budget::Interval(i.parse().unwrap()); }
    let t = std::time::Instant::now();
    let d = Design::new(&net, &o).unwrap();
    let b = hwgen_gen::generate(&d, &net);
    eprintln!("{:?} {:?} mult {} util {}", t.elapsed(), d.schedule(), d.multipliers(), d.mac_utilization());
    for l in d.perceptron().layers() { eprintln!("{} {:?} lanes {} {:?} sum {}", l.quant.name, l.fold, l.lanes, l.feed, l.quant.sum_width); }
    b.replace(std::path::Path::new(&a[2])).unwrap();
}
