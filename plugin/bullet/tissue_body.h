// TissueBody: the btSoftBody of a SoftTissue, by which its pairs with clouds know its tissues.
#pragma once

#include <BulletSoftBody/btSoftBody.h>
#include <cloudcontact/law/law.h>
#include <cloudcontact/law/tissue.h>

#include <vector>

namespace cloudcontact {

struct TissueBody : btSoftBody {
  using btSoftBody::btSoftBody;

  TissueTable tissues;
  std::vector<KelvinVoigt> springs;  // k and c of each node
  std::vector<double> areas;         // of the surface around each node at rest [m^2]
  double wholeArea = 0;              // before any cut
  int cuts = 0;                      // changes of `areas`
};

}  // namespace cloudcontact
