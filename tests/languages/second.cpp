/* A second unit of the program, to be linked with mollis.cpp. */
#include "mollis.hpp"

int second(mollis::result &result);

int second(mollis::result &result) {
  mollis::check(MOLLIS_ERR_MASS, result);
  return result.status;
}
