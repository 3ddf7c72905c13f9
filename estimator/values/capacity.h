// SPDX-License-Identifier: BSD-2-Clause
// Every fixed capacity of the estimator in one place, with its reason.
#pragma once

namespace facet {

/// Features tracked in one frame. 300 suffice indoors; 512 leaves room for dense meshes.
inline constexpr int kMaxFeatures = 512;
/// Corners of one keyframe matched in stereo for the mesh alone.
inline constexpr int kMaxSurfacePoints = 384;
/// Lost tracks that may be found again: those of the last seconds.
inline constexpr int kMaxDormantTracks = 256;
/// Keyframes in the window: 25 as in [Rosinol19], rounded up.
inline constexpr int kMaxKeyframes = 32;
/// Landmarks alive in the window: tracks of all its keyframes.
inline constexpr int kMaxLandmarks = 2048;
/// Planes known at a time: a room and its furniture, and those of the rooms before that a flight may come back to.
inline constexpr int kMaxPlanes = 24;
/// Landmarks on one plane: half of what a keyframe sees.
inline constexpr int kMaxPlaneLandmarks = 256;
/// Inertial samples between two keyframes: 4 s at 1 kHz.
inline constexpr int kMaxImuSamples = 4096;

}  // namespace facet
