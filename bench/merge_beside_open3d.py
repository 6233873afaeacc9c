#!/usr/bin/python3
"""Joins views of a turntable by Open3D: merge_beside_open3d.py TRUTH MERGED CLOUD...

TRUTH and MERGED: the JSON of `slipstream simulate --turntable` and of `slipstream merge`.
Prints for both programs pairs, seconds of processor time, and how far the turns are off."""

import json
import resource
import sys
import time

import numpy
import open3d

registration = getattr(open3d, "registration", None) or open3d.pipelines.registration
Hybrid = open3d.geometry.KDTreeSearchParamHybrid

KEYPOINTS, POINTS = 5.0, 1.5  # distances between them, mm
NEAR = 2.0  # points farther apart do not match, mm
LARGEST_TURN = 90  # degrees between views that may share surface
LEAST_OVERLAP = 0.15


def thinned(cloud, spacing):
    """Its points about that far apart, with normals towards the camera."""
    thin = cloud.voxel_down_sample(spacing)
    thin.estimate_normals(Hybrid(radius=2 * spacing, max_nn=30))
    thin.orient_normals_towards_camera_location()
    return thin


class View:
    def __init__(self, file):
        cloud = open3d.io.read_point_cloud(file)
        points = numpy.asarray(cloud.points)
        measured = numpy.isfinite(points).all(1) & (abs(points).sum(1) > 0)
        cloud = cloud.select_by_index(numpy.flatnonzero(measured))

        self.keypoints = thinned(cloud, KEYPOINTS)
        self.features = registration.compute_fpfh_feature(
            self.keypoints, Hybrid(radius=5 * KEYPOINTS, max_nn=100))
        self.points = thinned(cloud, POINTS)


def refined(first, second, pose, farthest):
    return registration.registration_icp(
        first.points, second.points, farthest, pose,
        registration.TransformationEstimationPointToPlane(),
        registration.ICPConvergenceCriteria(max_iteration=50))


def joined(first, second, pose=None):
    """The pose of the first view in the second's frame, its information and overlap."""
    if pose is None:
        start = registration.registration_ransac_based_on_feature_matching(
            first.keypoints, second.keypoints, first.features, second.features, True,
            1.5 * KEYPOINTS, registration.TransformationEstimationPointToPoint(False), 3,
            [registration.CorrespondenceCheckerBasedOnEdgeLength(0.9),
             registration.CorrespondenceCheckerBasedOnDistance(1.5 * KEYPOINTS)],
            registration.RANSACConvergenceCriteria(100_000, 0.999))
        pose = refined(first, second, start.transformation, KEYPOINTS).transformation

    found = refined(first, second, pose, NEAR)
    information = registration.get_information_matrix_from_point_clouds(
        first.points, second.points, NEAR, found.transformation)
    return found.transformation, information, found.fitness


def poses_of(views, step):
    """Poses of all views in the frame of the first, and the number of pairs."""
    # 1. Neighbours without a start; the last and the first close the loop.
    graph, pose = registration.PoseGraph(), numpy.eye(4)
    graph.nodes.append(registration.PoseGraphNode(pose))
    for k in range(1, len(views)):
        found, information, _ = joined(views[k - 1], views[k])
        pose = found @ pose
        graph.nodes.append(registration.PoseGraphNode(numpy.linalg.inv(pose)))
        graph.edges.append(registration.PoseGraphEdge(k - 1, k, found, information, False))
    found, information, _ = joined(views[-1], views[0])
    graph.edges.append(registration.PoseGraphEdge(len(views) - 1, 0, found, information, True))

    # 2. Up to eight further views of each, from near to far.
    reach = min(len(views) // 2 - 1, int(LARGEST_TURN / step))
    offsets = numpy.unique(numpy.rint(numpy.linspace(2, reach, 8)).astype(int)) if reach > 1 else []
    for first in range(len(views)):
        for offset in offsets:
            a, b = sorted((first, (first + offset) % len(views)))
            start = numpy.linalg.inv(graph.nodes[b].pose) @ graph.nodes[a].pose
            found, information, overlap = joined(views[a], views[b], start)
            if overlap >= LEAST_OVERLAP:
                graph.edges.append(registration.PoseGraphEdge(a, b, found, information, True))

    # 3. All poses at once.
    registration.global_optimization(
        graph, registration.GlobalOptimizationLevenbergMarquardt(),
        registration.GlobalOptimizationConvergenceCriteria(),
        registration.GlobalOptimizationOption(max_correspondence_distance=NEAR,
                                              edge_prune_threshold=0.25, reference_node=0))
    return [node.pose for node in graph.nodes], len(graph.edges)


def degrees_off(poses, axis, step):
    """RMS angle between the turn of each view and the true one, for the sense that fits."""
    def off(sense):
        angles = []
        for k, pose in enumerate(poses):
            turn = axis * numpy.radians(sense * step * k)
            true = open3d.geometry.get_rotation_matrix_from_axis_angle(turn)
            cosine = (numpy.trace(true.T @ numpy.asarray(pose)[:3, :3]) - 1) / 2
            angles.append(numpy.degrees(numpy.arccos(min(1, cosine))))
        return numpy.sqrt(numpy.mean(numpy.square(angles)))
    return min(off(1), off(-1))


truth, merged = (json.load(open(file)) for file in sys.argv[1:3])
axis, step = numpy.array(truth["axis_direction"]), 360 / len(sys.argv[3:])
own = degrees_off([view["pose"] for view in merged["views"]], axis, step)
print(f"slipstream  {len(merged['pairs']):5} pairs  {merged['seconds']:7.1f} s by the clock  "
      f"{own:.4f} degrees")

began = time.process_time()
poses, pairs = poses_of([View(file) for file in sys.argv[3:]], step)
print(f"Open3D      {pairs:5} pairs  {time.process_time() - began:7.1f} s of processor time  "
      f"{degrees_off(poses, axis, step):.4f} degrees  "
      f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024} MB")
