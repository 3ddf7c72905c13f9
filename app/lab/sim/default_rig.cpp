// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/default_rig.h"

namespace facet::sim {

Eigen::Matrix4d euroc_T_B_C(int camera) {
    Eigen::Matrix4d t;
    if (camera == 0) {
        t << 0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,  //
            0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,       //
            -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,   //
            0.0, 0.0, 0.0, 1.0;
    } else {
        t << 0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,  //
            0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024,     //
            -0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038,   //
            0.0, 0.0, 0.0, 1.0;
    }
    return t;
}

StereoRig euroc_rig() {
    CameraIntrinsics left{752,
                          480,
                          458.654,
                          457.296,
                          367.215,
                          248.375,
                          Distortion::kRadialTangential,
                          {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
    CameraIntrinsics right{752,
                           480,
                           457.587,
                           456.134,
                           379.999,
                           255.238,
                           Distortion::kRadialTangential,
                           {-0.28368365, 0.07451284, -0.00010473, -3.555907e-05}};
    return {CameraModel(left), CameraModel(right), Se3::from_matrix(euroc_T_B_C(0)), Se3::from_matrix(euroc_T_B_C(1))};
}

StereoRig fisheye_rig() {
    CameraIntrinsics left{752,
                          480,
                          270.214,
                          270.073,
                          377.382,
                          242.146,
                          Distortion::kEquidistant,
                          {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673}};
    CameraIntrinsics right{752,
                           480,
                           269.877,
                           269.951,
                           373.918,
                           237.529,
                           Distortion::kEquidistant,
                           {0.0034003171, 0.0017665971, -0.0026631460, 0.00032995260}};
    return {CameraModel(left), CameraModel(right), Se3::from_matrix(euroc_T_B_C(0)), Se3::from_matrix(euroc_T_B_C(1))};
}

StereoRig rig_with(LensKind lens) { return lens == LensKind::kFisheye ? fisheye_rig() : euroc_rig(); }

ImuNoise euroc_imu_noise() { return {1.6968e-4, 1.9393e-5, 2.0e-3, 3.0e-3, 200.0}; }

}  // namespace facet::sim
