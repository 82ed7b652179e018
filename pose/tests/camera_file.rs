//! Camera files as others write them, and what is refused of them.

use hwgen_pose::camera_file::{Calibration, Mount, read};
use hwgen_pose::scene::Distortion;

const ROS: &str = include_str!("data/cameras/ros.yaml");
const XML: &str = include_str!("data/cameras/opencv5.xml");

#[test]
fn every_writer_tells_the_same_camera() {
    let expected = Calibration {
        size_px: Some((1280.0, 720.0)),
        focal_px: (1010.0, 990.0),
        center_px: (650.0, 355.0),
        distortion: Distortion {
            radial: [-0.28, 0.07, 0.01],
            tangential: [1e-3, -5e-4],
        },
    };
    let files = [
        include_str!("data/cameras/opencv4.json"),
        include_str!("data/cameras/opencv4.xml"),
        include_str!("data/cameras/opencv4.yaml"),
        include_str!("data/cameras/opencv5.json"),
        XML,
        include_str!("data/cameras/opencv5.yaml"),
        include_str!("data/cameras/ros-message.yaml"),
        ROS,
    ];
    for file in files {
        assert_eq!(read(file.as_bytes()), Ok(expected), "{file}");
        let windows = file.replace('\n', "\r\n");
        assert_eq!(read(windows.as_bytes()), Ok(expected), "{file}");
    }
}

#[test]
fn u_points_up_from_the_lower_edge_of_the_image() {
    let mount = Mount {
        mount_rad: -0.1,
        offset_m: 0.5,
    };
    let calibration = read(ROS.as_bytes()).unwrap();
    let camera = calibration.camera(calibration.size_px.unwrap(), mount);
    assert_eq!((camera.width_px, camera.height_px), (1280.0, 720.0));
    assert_eq!((camera.focal_u_px, camera.focal_v_px), (990.0, 1010.0));
    assert_eq!((camera.center_u_px, camera.center_v_px), (365.0, 650.0));
    assert_eq!((camera.mount_rad, camera.offset_m), (-0.1, 0.5));
}

#[test]
fn refusals_name_the_place() {
    // Text to replace, by what; line and column; message.
    let cases = [
        (
            "plumb_bob",
            "equidistant",
            (8, 19),
            "distortion_model: the distortion model plumb_bob expected, a string equidistant found",
        ),
        (
            "plumb_bob",
            "rational_polynomial",
            (8, 19),
            "distortion_model: the distortion model plumb_bob expected, a string rational_polynomial found",
        ),
        (
            "[1010.0, 0.0,",
            "[1010.0, 0.5,",
            (7, 18),
            "camera_matrix.data[1]: 0 expected, 0.5 found",
        ),
        (
            "[1010.0, 0.0,",
            "[0.0, 0.0,",
            (7, 10),
            "camera_matrix.data[0]: a number above zero expected, 0.0 found",
        ),
        (
            "[1010.0, 0.0,",
            "[.nan, 0.0,",
            (7, 10),
            "camera_matrix.data[0]: a finite number expected, .nan found",
        ),
        (
            "[1010.0, 0.0,",
            "[fx, 0.0,",
            (7, 10),
            "camera_matrix.data[0]: a number expected, a string fx found",
        ),
        (
            "0.0, 0.0, 1.0]\ndist",
            "0.0, 0.0]\ndist",
            (5, 3),
            "camera_matrix: 9 numbers expected by the matrix's size, 8 found",
        ),
        (
            "-0.0005, 0.01]",
            "-0.0005, 0.01, 0.0, 0.0, 0.0]",
            (10, 3),
            "distortion_coefficients: 5 numbers expected by the matrix's size, 8 found",
        ),
        (
            "image_width: 1280\n",
            "",
            (1, 1),
            "the key image_width expected, only image_height, camera_name, camera_matrix... found",
        ),
        (
            "image_width: 1280\n",
            "image_width: 0\n",
            (1, 14),
            "image_width: a number above zero expected, 0 found",
        ),
        (
            "image_height: 720\n",
            "image_width: 720\n",
            (2, 1),
            "each key once expected, image_width found again",
        ),
        (
            "camera_matrix:",
            "camera_matrices:",
            (1, 1),
            "the key camera_matrix expected, only image_width, image_height, camera_name, ... found",
        ),
        (
            "distortion_coefficients:",
            "distortion:",
            (1, 1),
            "the key distortion_coefficients expected, only image_width, image_height, camera_name, ... found",
        ),
        (
            "camera_name: deck",
            "camera_name: &a deck\nb: *a",
            (4, 4),
            "a value expected, an alias found",
        ),
        (
            "camera_name: deck",
            "camera_name: deck\nbinning_x: 2",
            (4, 12),
            "binning_x: an image without binning expected, 2 found",
        ),
        (
            "camera_name: deck",
            "camera_name: deck\nroi: {x_offset: 8}",
            (4, 17),
            "roi.x_offset: the full image, 0, expected, 8 found",
        ),
        (
            "camera_name: deck",
            "fisheye_model: 1",
            (3, 16),
            "fisheye_model: a pinhole camera, 0, expected, 1 found",
        ),
        (
            "camera_name: deck",
            "a: 1\n---\nb: 1",
            (5, 1),
            "one document expected, a second found",
        ),
    ];
    for (from, to, place, message) in cases {
        assert!(ROS.contains(from), "{from}");
        let error = read(ROS.replacen(from, to, 1).as_bytes()).unwrap_err();
        let fault = error.fault();
        assert_eq!(error.to_string(), message);
        assert_eq!((fault.line, fault.column), place, "{message}");
        assert!(fault.help.is_some(), "{message}");
    }
}

#[test]
fn refusals_in_xml_name_the_place() {
    let cases = [
        (
            "1010. 0. 650.",
            "1010. 0.1 650.",
            (11, 11),
            "camera_matrix.data[1]: 0 expected, 0.1 found",
        ),
        (
            "</opencv_storage>",
            "",
            (18, 66),
            "the root node was opened but never closed",
        ),
        (
            "opencv_storage",
            "storage",
            (2, 1),
            "the element opencv_storage expected, storage found",
        ),
        (
            "0.070000000000000007",
            "x",
            (17, 26),
            "distortion_coefficients.data[1]: a number expected, a string x found",
        ),
        (
            "<image_width>1280</image_width>",
            "<image_width></image_width>",
            (4, 1),
            "image_width: a number expected, an empty array found",
        ),
    ];
    for (from, to, place, message) in cases {
        let text = XML.replace(from, to);
        assert_ne!(text, XML);
        let error = read(text.as_bytes()).unwrap_err();
        assert_eq!(error.to_string(), message);
        assert_eq!(
            (error.fault().line, error.fault().column),
            place,
            "{message}"
        );
    }
}

#[test]
fn what_is_no_camera_file_is_refused_without_panic() {
    let deep = "[".repeat(100_000);
    let texts = [
        "",
        "\n",
        "---\n",
        "1",
        "- 1\n- 2\n",
        "a: [",
        "\"",
        "<",
        "<a/>",
        "%YAML:1.0",
        "{}",
        &deep,
    ];
    for text in texts {
        assert!(read(text.as_bytes()).is_err(), "{text:.20}");
    }
    assert!(read(b"a: \xff").is_err());
    let xml = "<opencv_storage>".to_owned() + &"<a>".repeat(100_000);
    assert!(read(xml.as_bytes()).is_err());
    let bytes = ROS.as_bytes();
    for end in 0..bytes.len() {
        let _ = read(&bytes[..end]);
        let mut damaged = bytes.to_vec();
        damaged[end] = b'\'';
        let _ = read(&damaged);
    }
}
