//! Trained networks as estimators of a scene.

use hwgen_spec::network::FloatNet;
use nalgebra::Vector3;

use crate::frames::Pose;
use crate::scene::Scene;
use crate::solve::Estimator;
use crate::train::NETWORKS;

/// Which pixel each input reads, and which output is which number of the pose.
///
/// Both are found by name, as the training names them.
#[derive(Clone, Debug, PartialEq)]
pub struct Wiring {
    pixels: Vec<usize>,
    outputs: [usize; 6],
}

/// Why networks do not answer a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Misfit {
    /// Another number of inputs than the landmarks have pixel coordinates.
    #[error(
        "{expected} inputs expected, two for each landmark of the scene {scene}, {found} found"
    )]
    InputCount {
        /// The scene's name.
        scene: String,
        /// Two a landmark.
        expected: usize,
        /// Those of the networks.
        found: usize,
    },
    /// No input of a name.
    #[error("an input `{expected}` expected, {found} found")]
    Input {
        /// A pixel coordinate of the scene.
        expected: String,
        /// The inputs there are.
        found: String,
    },
    /// No output of a name.
    #[error("an output `{expected}` expected, {found} found")]
    Output {
        /// A number of the pose.
        expected: String,
        /// The outputs there are.
        found: String,
    },
    /// Another unit than that of the pose or the pixels.
    #[error("the unit {expected} expected, `{found}` found")]
    Unit {
        /// Where in the weights file.
        path: String,
        /// What the numbers must be in.
        expected: &'static str,
        /// What they are in.
        found: String,
    },
}

impl Misfit {
    /// The place in the weights file.
    pub fn path(&self) -> &str {
        match self {
            Self::InputCount { .. } => "inputs",
            Self::Input { .. } => "inputs.names",
            Self::Output { .. } => "networks",
            Self::Unit { path, .. } => path,
        }
    }

    /// How to mend it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::InputCount { .. } => "give the scene that the networks were trained for",
            Self::Input { .. } => "landmark i of the scene is seen at u<i>, v<i>",
            Self::Output { .. } => {
                "a network `position` with outputs x, y, z and a network `orientation` with \
                 outputs rx, ry, rz give a pose"
            }
            Self::Unit { .. } => "pixels are in px, positions in m, Rodrigues vectors in rad",
        }
    }
}

impl Wiring {
    /// How networks are wired to a scene.
    ///
    /// # Errors
    /// If they do not read its pixels, or do not answer with a pose.
    pub fn new(net: &FloatNet, scene: &Scene) -> Result<Self, Misfit> {
        let names = scene.input_names();
        if net.inputs.names.len() != names.len() {
            return Err(Misfit::InputCount {
                scene: scene.name().to_string(),
                expected: names.len(),
                found: net.inputs.names.len(),
            });
        }
        if let Some(missing) = names.iter().find(|name| !net.inputs.names.contains(name)) {
            return Err(Misfit::Input {
                expected: missing.clone(),
                found: net.inputs.names.join(", "),
            });
        }
        same_unit("inputs.unit".to_string(), "px", &net.inputs.unit)?;
        let place = |name: &String| names.iter().position(|known| known == name);
        let pixels = net.inputs.names.iter().filter_map(place).collect();

        let columns = net.output_columns();
        let mut outputs = [0; 6];
        let wanted = NETWORKS
            .iter()
            .flat_map(|(network, names, _)| names.map(|name| format!("{network}.{name}")));
        for (output, name) in outputs.iter_mut().zip(wanted) {
            match columns.iter().position(|column| *column == name) {
                Some(index) => *output = index,
                None => {
                    return Err(Misfit::Output {
                        expected: name,
                        found: columns.join(", "),
                    });
                }
            }
        }
        for (name, _, unit) in NETWORKS {
            for (i, network) in net.networks.iter().enumerate() {
                if network.name == name {
                    same_unit(
                        format!("networks[{i}].outputs.unit"),
                        unit,
                        &network.outputs.unit,
                    )?;
                }
            }
        }
        Ok(Self { pixels, outputs })
    }

    /// Pixels `[u0, v0, u1, v1, ...]` in the order of the networks' inputs.
    pub fn inputs(&self, pixels: &[f64]) -> Vec<f64> {
        self.pixels.iter().map(|i| pixels[*i]).collect()
    }

    /// The pose that the outputs of all networks, in real units, say; `None` if one is not finite.
    pub fn pose(&self, outputs: &[f64]) -> Option<Pose> {
        let [x, y, z, rx, ry, rz] = self.outputs.map(|i| outputs[i]);
        [x, y, z, rx, ry, rz]
            .iter()
            .all(|value| value.is_finite())
            .then(|| Pose::new(Vector3::new(x, y, z), Vector3::new(rx, ry, rz)))
    }
}

/// No unit at all is taken for the right one.
fn same_unit(path: String, expected: &'static str, found: &str) -> Result<(), Misfit> {
    if found.is_empty() || found == expected {
        return Ok(());
    }
    Err(Misfit::Unit {
        path,
        expected,
        found: found.to_string(),
    })
}

/// Networks in floating point.
#[derive(Clone, Debug)]
pub struct FloatEstimator<'a> {
    net: &'a FloatNet,
    wiring: &'a Wiring,
}

impl<'a> FloatEstimator<'a> {
    /// The networks, wired to a scene.
    pub fn new(net: &'a FloatNet, wiring: &'a Wiring) -> Self {
        Self { net, wiring }
    }
}

impl Estimator for FloatEstimator<'_> {
    fn name(&self) -> &'static str {
        "network-float"
    }

    fn estimate(&self, pixels: &[f64]) -> Option<Pose> {
        let outputs = self.net.forward(&self.wiring.inputs(pixels));
        self.wiring.pose(&outputs)
    }
}
