//! A scene as TOML.

use std::fmt::Write;

use super::POSES_KEYS;
use crate::scene::{Camera, Scene};

/// A scene as the text of a scene file that [`read`](super::read) gives back as the same scene.
///
/// The camera's numbers stand in it even if a calibration gave them.
/// An angle that no number of degrees makes is written as one that is off by a rounding.
pub fn write(scene: &Scene) -> String {
    let mut text = format!("name = \"{}\"\nlandmarks = [ # m\n", scene.name());
    for l in scene.landmarks_m() {
        // Writing to memory does not fail.
        let _ = writeln!(text, "    [{:?}, {:?}, {:?}],", l.x, l.y, l.z);
    }
    text.push_str("]\n\n[camera]\n");
    write_camera(&mut text, scene.camera());
    text.push_str("\n[poses]\n");
    let poses = scene.poses();
    for (i, key) in POSES_KEYS[..poses.lower.len()].iter().enumerate() {
        let unit = |value| if i == 0 { value } else { degrees(value) };
        let (lower, upper) = (unit(poses.lower[i]), unit(poses.upper[i]));
        let _ = writeln!(text, "{key} = [{lower:?}, {upper:?}]");
    }
    let _ = writeln!(text, "margin_px = {:?}", scene.margin_px());
    text
}

fn write_camera(text: &mut String, camera: &Camera) {
    let (u, v) = (camera.focal_u_px, camera.focal_v_px);
    let focal = if u == v {
        format!("{u:?}")
    } else {
        format!("[{u:?}, {v:?}]")
    };
    let _ = write!(
        text,
        "width_px = {:?}\nheight_px = {:?}\nfocal_px = {focal}\ncenter_u_px = {:?}\n\
         center_v_px = {:?}\nmount_deg = {:?}\noffset_m = {:?}\n",
        camera.width_px,
        camera.height_px,
        camera.center_u_px,
        camera.center_v_px,
        degrees(camera.mount_rad),
        camera.offset_m,
    );
    if !camera.distortion.is_none() {
        let [k1, k2, k3] = camera.distortion.radial;
        let [p1, p2] = camera.distortion.tangential;
        let _ = writeln!(
            text,
            "distortion = {{ k1 = {k1:?}, k2 = {k2:?}, p1 = {p1:?}, p2 = {p2:?}, k3 = {k3:?} }}"
        );
    }
}

/// The shortest number of degrees that makes the angle.
fn degrees(angle_rad: f64) -> f64 {
    const DIGITS: usize = 17;
    let nearest = angle_rad.to_degrees();
    let rounded = (0..DIGITS).filter_map(|digits| format!("{nearest:.digits$e}").parse().ok());
    let beside = [nearest, nearest.next_up(), nearest.next_down()];
    rounded
        .chain(beside)
        .find(|degrees: &f64| degrees.to_radians() == angle_rad)
        .unwrap_or(nearest)
}
