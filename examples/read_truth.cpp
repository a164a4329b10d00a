// Reads a table of a dataset with Arrow C++ and prints, for each column of floats, its name, its unit, and the sum of
// its values as an exact hexadecimal number.
//
//   c++ -std=c++20 read_truth.cpp -larrow -lparquet -o read_truth && ./read_truth truth.parquet

#include <cstdio>
#include <iostream>
#include <memory>
#include <string>

#include <arrow/api.h>
#include <arrow/io/file.h>
#include <parquet/arrow/reader.h>

namespace {

arrow::Status Run(const std::string& path) {
  ARROW_ASSIGN_OR_RAISE(auto file, arrow::io::ReadableFile::Open(path));
  parquet::arrow::FileReaderBuilder builder;
  ARROW_RETURN_NOT_OK(builder.Open(file));
  std::unique_ptr<parquet::arrow::FileReader> reader;
  ARROW_RETURN_NOT_OK(builder.Build(&reader));
  std::shared_ptr<arrow::Schema> schema;
  ARROW_RETURN_NOT_OK(reader->GetSchema(&schema));
  for (int column = 0; column < schema->num_fields(); ++column) {
    const auto& field = schema->field(column);
    if (field->type()->id() != arrow::Type::DOUBLE) continue;
    std::shared_ptr<arrow::ChunkedArray> values;
    ARROW_RETURN_NOT_OK(reader->ReadColumn(column, &values));
    double sum = 0;  // in the order of the rows: the same additions give the same number in any language
    for (const auto& chunk : values->chunks()) {
      const auto& numbers = static_cast<const arrow::DoubleArray&>(*chunk);
      for (int64_t row = 0; row < numbers.length(); ++row) {
        if (numbers.IsValid(row)) sum += numbers.Value(row);
      }
    }
    const auto unit = field->metadata() ? field->metadata()->Get("unit").ValueOr("") : std::string();
    std::printf("%s,%s,%a\n", field->name().c_str(), unit.c_str(), sum);
  }
  return arrow::Status::OK();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: read_truth FILE.parquet\n";
    return 2;
  }
  const arrow::Status status = Run(argv[1]);
  if (!status.ok()) std::cerr << status.ToString() << "\n";
  return status.ok() ? 0 : 1;
}
