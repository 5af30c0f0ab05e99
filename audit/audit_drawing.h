/// The result of an audit for people and for other programs: a picture and an OBJ file.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/edges/audit_table.h"

namespace edge_mcl {

/// Draws the lines of an audit, coloured by verdict, with their lengths.
cv::Mat drawAudit(const std::vector<AuditRow>& rows, cv::Size size);

/// Writes the lines of an audit to an OBJ file, in one object for each verdict. The coordinates are
/// those of the table. @throws InputError when the file cannot be written.
void writeAuditObj(const std::string& file, const std::vector<AuditRow>& rows);

/// Length of the lines of each verdict, metres, in the order confirmed, unseen, doubtful, gone,
/// new, marking.
std::vector<std::pair<std::string, double>> lengthsOf(const std::vector<AuditRow>& rows);

}  // namespace edge_mcl
