# The cell of ../yade/recorder/rough-pericell.125200.vtu in the ways in which VTK 9.7.2 writes its arrays. Run here: python3 variants.py
import vtk
reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName("../yade/recorder/rough-pericell.125200.vtu")
reader.Update()
ways = {
    "ascii": lambda w: w.SetDataModeToAscii(),
    "inline": lambda w: (w.SetDataModeToBinary(), w.SetCompressorTypeToNone()),
    "inline-zlib-64": lambda w: (w.SetDataModeToBinary(), w.SetCompressorTypeToZLib(), w.SetHeaderTypeToUInt64()),
    "raw": lambda w: (w.SetDataModeToAppended(), w.EncodeAppendedDataOff(), w.SetCompressorTypeToNone()),
    "raw-zlib-blocks": lambda w: (w.SetDataModeToAppended(), w.EncodeAppendedDataOff(), w.SetCompressorTypeToZLib(), w.SetBlockSize(48)),
    "raw-big-endian-64": lambda w: (w.SetDataModeToAppended(), w.EncodeAppendedDataOff(), w.SetCompressorTypeToNone(),
                                    w.SetByteOrderToBigEndian(), w.SetHeaderTypeToUInt64()),
    "appended": lambda w: (w.SetDataModeToAppended(), w.EncodeAppendedDataOn(), w.SetCompressorTypeToNone()),
    "lz4": lambda w: (w.SetDataModeToAppended(), w.SetCompressorTypeToLZ4()),
}
for name, way in ways.items():
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(name + ".vtu")
    writer.SetInputData(reader.GetOutput())
    way(writer)
    writer.Write()
