# A program may be built with any version from its own on, as long as the first number is the same.
set(PACKAGE_VERSION @version@)
if(PACKAGE_FIND_VERSION VERSION_EQUAL PACKAGE_VERSION)
  set(PACKAGE_VERSION_EXACT TRUE)
endif()
string(REGEX MATCH "^[0-9]+" series ${PACKAGE_VERSION})
if(PACKAGE_FIND_VERSION_MAJOR EQUAL series AND NOT PACKAGE_FIND_VERSION VERSION_GREATER PACKAGE_VERSION)
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
