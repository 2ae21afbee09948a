// Elements of our own in SDFormat files, with the prefix `cloudcontact:`: tissues, cutting,
// the paper's C, Gr and D, and driven bodies. libsdformat keeps such elements as they are.
#pragma once

#include <optional>
#include <sdf/Element.hh>
#include <string>

#include "scene/scene.h"

namespace cloudcontact::program {

// Throws BadInput naming `file` for an element with our prefix, anywhere below `root`, that is not
// known, stands in the wrong place, or has an attribute or a part that is not known.
void checkOwnElements(const std::string& file, const sdf::ElementPtr& root);

// Reads the elements of a <collision>. `where` names the file and the collision in messages. Throws
// BadInput.
void readOwnElements(const std::string& where, const sdf::ElementPtr& collision,
                     SceneCollision& out);

// The <drive> of a <link>, if there is one. `linkInBody`: the link's frame in the body's. Throws
// BadInput.
std::optional<SceneDrive> readDrive(const std::string& where, const sdf::ElementPtr& link,
                                    const Pose& linkInBody);

}  // namespace cloudcontact::program
