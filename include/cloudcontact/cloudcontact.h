// Every public header but Bullet's, which bullet.h includes.
#pragma once

#include <cloudcontact/version.h>

#include <cloudcontact/base/mass_properties.h>
#include <cloudcontact/base/pose.h>
#include <cloudcontact/base/source_hash.h>
#include <cloudcontact/base/span.h>
#include <cloudcontact/base/task_runner.h>
#include <cloudcontact/base/wrench.h>

#include <cloudcontact/mesh/assimp_mesh.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>

#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/cloud_file.h>
#include <cloudcontact/voxels/column_cloud.h>
#include <cloudcontact/voxels/ct_volume.h>
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/voxels/digitize_settings.h>
#include <cloudcontact/voxels/display_mesh.h>
#include <cloudcontact/voxels/matter_sums.h>
#include <cloudcontact/voxels/pieces.h>
#include <cloudcontact/voxels/volume_file.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <cloudcontact/objects/depth_image.h>
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/objects/object_file.h>
#include <cloudcontact/objects/octree.h>
#include <cloudcontact/objects/point_cloud.h>
#include <cloudcontact/objects/point_file.h>
#include <cloudcontact/objects/sphere_cloud.h>
#include <cloudcontact/objects/sphere_tree.h>

#include <cloudcontact/law/automatic_spring.h>
#include <cloudcontact/law/law.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/law/tissue.h>

#include <cloudcontact/field/field_file.h>
#include <cloudcontact/field/recognized_shape.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/field/surface_sample.h>

#include <cloudcontact/contact/contact.h>
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/contact/work_counts.h>

#include <cloudcontact/field/base_vector_field.h>
#include <cloudcontact/field/window.h>
#include <cloudcontact/workpiece/cloud_solid.h>
#include <cloudcontact/workpiece/collision_finder.h>
#include <cloudcontact/workpiece/cutter.h>
#include <cloudcontact/workpiece/embedding.h>
#include <cloudcontact/workpiece/energy_watch.h>
#include <cloudcontact/workpiece/haptic_loop.h>
#include <cloudcontact/workpiece/interference.h>
#include <cloudcontact/workpiece/reaction.h>
#include <cloudcontact/workpiece/simulated_hand.h>

#include <cloudcontact/device/backend.h>
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/device/device_list.h>
#include <cloudcontact/device/device_workpiece.h>
#include <cloudcontact/device/digitizer.h>
