// NodeMatter: the matter around one node of soft tissue.
#pragma once

namespace cloudcontact {

// k, c and elasticity are means over the matter by volume, (1) and (2).
struct NodeMatter {
  int tissue = 0;         // the one with the most volume there, an index into SoftTissue::tissues()
  double mass = 0;        // [kg]
  double stiffness = 0;   // k [N/m], as Tissue
  double damping = 0;     // c [N s/m]
  double elasticity = 0;  // [Pa]
};

}  // namespace cloudcontact
