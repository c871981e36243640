const [text, ...pieces] = content.pieces;
const row = (value) => {
  if (value == null || value.piece == null) return value;
  const piece = pieces[value.piece];
  return value.size == null ? piece : new Float64Array(piece.buffer, piece.byteOffset + 8 * value.begin, value.size);
};
for (const [name, columns] of Object.entries(JSON.parse(text))) {
  for (const [column, rows] of Object.entries(columns)) sources[name].data[column] = rows.map(row);
  sources[name].change.emit();  // not sent back to the server, as setting the data would be
}
