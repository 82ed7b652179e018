//! Camera files of others: OpenCV's `FileStorage` in YAML, XML or JSON, and ROS `camera_info` in
//! YAML.
//!
//! # Units
//! OpenCV's image has x to the right and y down; the centre of its first pixel is at (0, 0).
//! Here v = x, and u = height - y points up.
//! So the image, whose pixels are taken as squares, reaches from -0.5 to width - 0.5 in v, and
//! from 0.5 to height + 0.5 in u.
//! The focal lengths are `focal_u = fy` and `focal_v = fx`, the centre `u = height - cy`, `v = cx`.
//!
//! # Source
//! OpenCV 4, `FileStorage` and the model of `projectPoints`; ROS, `sensor_msgs/CameraInfo`.
//!
//! ```
//! let text = br#"%YAML:1.0
//! ---
//! image_width: 1280
//! image_height: 720
//! camera_matrix: !!opencv-matrix
//!    rows: 3
//!    cols: 3
//!    dt: d
//!    data: [ 1010., 0., 640., 0., 1000., 350., 0., 0., 1. ]
//! distortion_coefficients: !!opencv-matrix
//!    rows: 1
//!    cols: 5
//!    dt: d
//!    data: [ -1.0e-01, 2.0e-02, 0., 0., 0. ]
//! "#;
//! let calibration = hwgen_pose::camera_file::read(text)?;
//! assert_eq!(calibration.size_px, Some((1280.0, 720.0)));
//! assert_eq!(calibration.focal_px, (1010.0, 1000.0));
//! assert_eq!(calibration.distortion.radial, [-0.1, 0.02, 0.0]);
//! # Ok::<(), hwgen_pose::error::FileError>(())
//! ```

use hwgen_spec::json::Fault;

use crate::document::{At, Document, Table};
use crate::error::FileError;
use crate::scene::{Camera, Distortion};

/// What a camera file tells, in OpenCV's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Width and height of the image, if the file knows them.
    pub size_px: Option<(f64, f64)>,
    /// Focal lengths fx and fy.
    pub focal_px: (f64, f64),
    /// Principal point cx, cy.
    pub center_px: (f64, f64),
    /// Lens distortion.
    pub distortion: Distortion,
}

/// What writers call the camera matrix.
const MATRIX: &[&str] = &["camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k"];
/// What writers call the distortion coefficients.
const COEFFICIENTS: &[&str] = &[
    "distortion_coefficients",
    "Distortion_Coefficients",
    "distCoeffs",
    "dist_coeffs",
    "D",
    "d",
];
const WIDTH: &[&str] = &["image_width", "image_Width", "width"];
const HEIGHT: &[&str] = &["image_height", "image_Height", "height"];

/// Reads a camera file; keys that do not matter are skipped.
///
/// # Errors
/// The first fault with its place: syntax, a missing key, a matrix of another shape, skew, a
/// distortion model other than `plumb_bob`, more than five coefficients, a cropped or binned image.
pub fn read(text: &[u8]) -> Result<Calibration, FileError> {
    let document = Document::xml_or_yaml(text)?;
    let table = document
        .root()
        .table("camera_matrix and what belongs to it")?;
    check_model(table)?;
    let [fx, fy, cx, cy] = matrix(table)?;
    let distortion = coefficients(table)?;
    let size_px = match (table.first_of(WIDTH), table.first_of(HEIGHT)) {
        (Some(width), Some(height)) => Some((width.positive()?, height.positive()?)),
        (None, None) => None,
        (Some(_), None) => return Err(table.missing(HEIGHT[0], "image_height: 720").into()),
        (None, Some(_)) => return Err(table.missing(WIDTH[0], "image_width: 1280").into()),
    };
    Ok(Calibration {
        size_px,
        focal_px: (fx, fy),
        center_px: (cx, cy),
        distortion,
    })
}

/// How a camera stands on the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount {
    /// Mount angle about the body's Z; negative looks down.
    pub mount_rad: f64,
    /// How far the camera stands ahead of the body's origin.
    pub offset_m: f64,
}

impl Calibration {
    /// The camera with these intrinsics, an image of a width and a height, and a mount.
    ///
    /// # Units
    /// px
    pub fn camera(&self, (width_px, height_px): (f64, f64), mount: Mount) -> Camera {
        Camera {
            width_px,
            height_px,
            focal_u_px: self.focal_px.1,
            focal_v_px: self.focal_px.0,
            center_u_px: height_px - self.center_px.1,
            center_v_px: self.center_px.0,
            mount_rad: mount.mount_rad,
            offset_m: mount.offset_m,
            distortion: self.distortion,
        }
    }
}

/// Refuses what another projection than ours made.
fn check_model(table: Table<'_>) -> Result<(), Fault> {
    let unsupported = |at: At<'_>, expected: &str| {
        let message = format!("{expected} expected, {} found", at.describe());
        at.fault("camera-model", message)
    };
    if let Some(at) = table.optional("distortion_model")
        && at.text()? != "plumb_bob"
    {
        return Err(unsupported(at, "the distortion model plumb_bob")
            .help("calibrate with the pinhole model and its five coefficients"));
    }
    if let Some(at) = table.optional("fisheye_model")
        && at.number()? != 0.0
    {
        return Err(unsupported(at, "a pinhole camera, 0,")
            .help("calibrate with the pinhole model and its five coefficients"));
    }
    let crop = table.optional("roi").and_then(At::as_table);
    let full = "rectify for the full image, without region of interest and binning";
    for at in ["binning_x", "binning_y"]
        .into_iter()
        .filter_map(|key| table.optional(key))
    {
        if at.number()? > 1.0 {
            return Err(unsupported(at, "an image without binning").help(full));
        }
    }
    for at in ["x_offset", "y_offset"]
        .into_iter()
        .filter_map(|key| crop?.optional(key))
    {
        if at.number()? != 0.0 {
            return Err(unsupported(at, "the full image, 0,").help(full));
        }
    }
    Ok(())
}

/// fx, fy, cx, cy.
fn matrix(table: Table<'_>) -> Result<[f64; 4], Fault> {
    let example = "camera_matrix, 3 rows of 3: [fx, 0, cx, 0, fy, cy, 0, 0, 1]";
    let at = table
        .first_of(MATRIX)
        .ok_or_else(|| table.missing(MATRIX[0], example))?;
    let cells = cells(at)?;
    if cells.len() != 9 {
        let message = format!("9 numbers expected, {} found", cells.len());
        return Err(at
            .fault("wrong-length", message)
            .help(format!("give {example}")));
    }
    let mut k = [0.0; 9];
    for (number, cell) in k.iter_mut().zip(&cells) {
        *number = cell.number()?;
    }
    let fixed = [(1, 0.0), (3, 0.0), (6, 0.0), (7, 0.0), (8, 1.0)];
    for (i, value) in fixed {
        if k[i] != value {
            let message = format!("{value} expected, {} found", cells[i].describe());
            let fault = cells[i].fault("camera-matrix", message);
            return Err(if i == 1 {
                fault.help("this is skew, which no model here has; calibrate without it")
            } else {
                fault.help("the matrix is [fx, 0, cx, 0, fy, cy, 0, 0, 1] by rows")
            });
        }
    }
    let focal = |i: usize| {
        let fault = |f: Fault| f.help("a matrix of zeros is that of a camera not yet calibrated");
        cells[i].positive().map_err(fault)
    };
    Ok([focal(0)?, focal(4)?, k[2], k[5]])
}

fn coefficients(table: Table<'_>) -> Result<Distortion, Fault> {
    let example = "distortion_coefficients: [k1, k2, p1, p2, k3], zeros if there is none";
    let at = table
        .first_of(COEFFICIENTS)
        .ok_or_else(|| table.missing(COEFFICIENTS[0], example))?;
    let cells = cells(at)?;
    if ![0, 4, 5].contains(&cells.len()) {
        let message = format!("4 or 5 numbers expected, {} found", cells.len());
        let fault = at.fault("wrong-length", message);
        return Err(fault.help("calibrate with k1, k2, p1, p2, k3 only, or without distortion"));
    }
    let mut numbers = [0.0; 5];
    for (number, cell) in numbers.iter_mut().zip(cells) {
        *number = cell.number()?;
    }
    let [k1, k2, p1, p2, k3] = numbers;
    Ok(Distortion {
        radial: [k1, k2, k3],
        tangential: [p1, p2],
    })
}

/// The numbers of a matrix by rows: size and `data`, or arrays.
fn cells(at: At<'_>) -> Result<Vec<At<'_>>, Fault> {
    let Some(table) = at.as_table() else {
        return flat(at);
    };
    let data = flat(table.required("data", "data: [...], the numbers by rows")?)?;
    let product: f64 = match table.optional("sizes") {
        // OpenCV 5 writes a vector so; in XML a single size is no array.
        Some(sizes) => match sizes.as_array() {
            Some(sizes) => sizes.map(At::number).product::<Result<_, _>>()?,
            None => sizes.number()?,
        },
        None => {
            let rows = table.required("rows", "rows: 3")?.number()?;
            rows * table.required("cols", "cols: 3")?.number()?
        }
    };
    #[expect(clippy::cast_precision_loss, reason = "a file of a mebibyte has fewer")]
    let count = data.len() as f64;
    if product != count {
        let message = format!("{product} numbers expected by the matrix's size, {count} found");
        return Err(at
            .fault("wrong-length", message)
            .help("write the whole matrix by rows"));
    }
    Ok(data)
}

/// The elements of an array, those of arrays in it one after the other.
fn flat(at: At<'_>) -> Result<Vec<At<'_>>, Fault> {
    let mut cells = Vec::new();
    for item in at.array("[...]")? {
        match item.as_array() {
            Some(row) => cells.extend(row),
            None => cells.push(item),
        }
    }
    Ok(cells)
}
