// Clouds in Bullet worlds: every public header that needs Bullet, and what makes bodies of meshes
// (loadMesh() is in the component "files").
#pragma once

#include <cloudcontact/bullet/cloud_body.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_contact_settings.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/bullet/cuttable_body.h>
#include <cloudcontact/bullet/diagnosis.h>
#include <cloudcontact/bullet/fidelity.h>
#include <cloudcontact/bullet/newton_solver.h>
#include <cloudcontact/bullet/node_matter.h>
#include <cloudcontact/bullet/ordered_dispatcher.h>
#include <cloudcontact/bullet/query.h>
#include <cloudcontact/bullet/shape_report.h>
#include <cloudcontact/bullet/soft_contact_point.h>
#include <cloudcontact/bullet/soft_tissue.h>
#include <cloudcontact/bullet/striding_mesh.h>
#include <cloudcontact/bullet/world_cutter.h>
#include <cloudcontact/bullet/world_file.h>
#include <cloudcontact/bullet/world_hand.h>
#include <cloudcontact/bullet/world_state.h>

#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/voxels/digitize.h>
