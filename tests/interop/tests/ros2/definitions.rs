//! Our declared messages beside the definitions of a real ROS 2: standard ones are those of its packages.
//!
//! Must never do: compare with definitions of our own, but for the two packages that are not on PyPI (see `tests/interop/ros2`).

use anyhow::{Context, Result, ensure};
use skein_ros2::interfaces::{self, Interface};
use skein_tests_interop::Ros2;

/// Name and type of each field in a definition, with whole names of types.
fn defined(text: &str, package: &str) -> Vec<(String, String)> {
    let fields = text
        .lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim());
    fields
        .filter(|line| !line.is_empty() && !line.contains('='))
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            let (kind, name) = (words.next()?, words.next()?);
            let is_own = !kind.contains('/') && kind.starts_with(|c: char| c.is_ascii_uppercase());
            let kind = if is_own {
                format!("{package}/{kind}")
            } else {
                kind.to_owned()
            };
            Some((name.to_owned(), kind.replace("byte", "uint8")))
        })
        .collect()
}

fn is_defined_so<T: Interface>(ros2: &Ros2) -> Result<()> {
    let path = ros2
        .share()
        .join(T::PACKAGE)
        .join("msg")
        .join(format!("{}.msg", T::NAME));
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let own: Vec<_> = T::fields()
        .into_iter()
        .map(|(name, kind)| (name.to_owned(), kind))
        .collect();
    ensure!(defined(&text, T::PACKAGE) == own, "{}: {text}\n{own:?}", path.display());
    Ok(())
}

#[test]
fn standard_messages_are_those_of_ros_2() -> Result<()> {
    use interfaces::{diagnostic, geometry, nav, sensor, standard, vision};
    let ros2 = Ros2::jazzy()?;
    is_defined_so::<standard::Time>(&ros2)?;
    is_defined_so::<standard::Header>(&ros2)?;
    is_defined_so::<geometry::Point>(&ros2)?;
    is_defined_so::<geometry::Vector3>(&ros2)?;
    is_defined_so::<geometry::Quaternion>(&ros2)?;
    is_defined_so::<geometry::Pose>(&ros2)?;
    is_defined_so::<geometry::PoseStamped>(&ros2)?;
    is_defined_so::<geometry::PoseWithCovariance>(&ros2)?;
    is_defined_so::<geometry::Twist>(&ros2)?;
    is_defined_so::<geometry::TwistWithCovariance>(&ros2)?;
    is_defined_so::<geometry::Transform>(&ros2)?;
    is_defined_so::<geometry::TransformStamped>(&ros2)?;
    is_defined_so::<nav::Odometry>(&ros2)?;
    is_defined_so::<sensor::NavSatStatus>(&ros2)?;
    is_defined_so::<sensor::NavSatFix>(&ros2)?;
    is_defined_so::<sensor::BatteryState>(&ros2)?;
    is_defined_so::<sensor::CompressedImage>(&ros2)?;
    is_defined_so::<sensor::RegionOfInterest>(&ros2)?;
    is_defined_so::<sensor::CameraInfo>(&ros2)?;
    is_defined_so::<diagnostic::KeyValue>(&ros2)?;
    is_defined_so::<diagnostic::DiagnosticStatus>(&ros2)?;
    is_defined_so::<diagnostic::DiagnosticArray>(&ros2)?;
    is_defined_so::<geometry::TFMessage>(&ros2)?;
    is_defined_so::<vision::ObjectHypothesis>(&ros2)?;
    is_defined_so::<vision::ObjectHypothesisWithPose>(&ros2)?;
    is_defined_so::<vision::Point2D>(&ros2)?;
    is_defined_so::<vision::Pose2D>(&ros2)?;
    is_defined_so::<vision::BoundingBox2D>(&ros2)?;
    is_defined_so::<vision::Detection2D>(&ros2)?;
    is_defined_so::<vision::Detection2DArray>(&ros2)?;
    is_defined_so::<vision::BoundingBox3D>(&ros2)?;
    is_defined_so::<vision::Detection3D>(&ros2)?;
    is_defined_so::<vision::Detection3DArray>(&ros2)
}
